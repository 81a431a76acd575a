"""Whether a card works: a small program runs on it."""

from typing import Any

import numpy as np

from swarmcensus.gpu.driver import CardError, open_driver

DOUBLING = """
struct Given { double *numbers; };

extern "C" __global__ void doubled(Given given) {
    const int place = blockIdx.x * blockDim.x + threadIdx.x;
    given.numbers[place] = 2.0 * given.numbers[place];
}
"""


def examine() -> dict[str, Any]:
    """What this machine's card is, once a small program has run on it. Raises CardError."""
    driver, numbers = open_driver(), np.arange(64.0)
    buffer, found = driver.upload(numbers), np.empty(64)
    driver.launch(driver.build(DOUBLING), "doubled", 2, 32, 0, np.uint64(buffer.address).tobytes())
    driver.wait(np.zeros(1, np.uint8))
    driver.download(buffer, found)
    if not np.array_equal(found, 2.0 * numbers):
        raise CardError(f"{driver.name} computes wrongly: twice 0 to 63 is {found.tolist()}"[:200])
    return {"name": driver.name, "cuda": driver.cuda, "gigabytes": driver.free() / 1e9}
