"""Messages call options as whoever asks would write them: `--against swift` in a shell, `against='swift'` in Python."""

import pytest

import swarmcensus as sc
from swarmcensus.support.options import option, shell_options
from tests.support.contending import made_up


def test_an_option_is_written_as_it_would_be_given():
    assert [option("against", "swift"), option("out"), option("fresh", True)] == [
        "against='swift'",
        "out=",
        "fresh=True",
    ]
    with shell_options(["against", "error_limit", "out", "fresh"]):
        told = [option("against", "a b"), option("error_limit", 2), option("out"), option("fresh", True)]
    assert told == ["--against 'a b'", "--error-limit 2", "--out", "--fresh"]
    with shell_options(["metric", "option"]):
        told = [option("metric", "correct"), option("against", "swift")]
    assert told == ["--metric correct", "--option against=swift"]
    assert option("out") == "out="


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda data: sc.plot.compare(data, against="swit"), "against='swit': "),
        (lambda data: sc.compare(data, against="swit"), "against='swit': "),
        (lambda data: sc.compare(data, metric="rubbish"), "metric='rubbish': "),
        (lambda data: sc.compare(data, where="robots = 3"), "where='robots = 3': "),
        (lambda data: sc.plot.ranks(data, metric="final_error:up"), "metric='final_error:up': "),
        (lambda data: sc.plot.compare(data, by="colour"), "by='colour': "),
    ],
)
def test_python_reads_of_its_arguments(ask, said):
    with pytest.raises(sc.InputError) as caught:
        ask(made_up())
    assert str(caught.value).startswith(said)
    assert "--" not in str(caught.value)
