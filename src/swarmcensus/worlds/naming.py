"""What results, tables and figures call a topology or floor, and those of its keys of which a study gives a list."""

from abc import ABC, abstractmethod
from typing import Any

from swarmcensus.support.plugins import Keys, text_of


class Titled(ABC):
    """Something with a name, perhaps a label in place of it, and keys; `spanned` are those that span the grid."""

    name: str
    label: str
    keys: Keys
    spanned: tuple[str, ...]

    def __str__(self) -> str:
        """As in the dataset: the label, or the name without keys that span the grid, which are coordinates there."""
        return self.label or self.name_without(self.spanned)

    @abstractmethod
    def name_without(self, keys: tuple[str, ...]) -> str:
        """Its name if some of its keys are not shown."""

    @property
    def parameters(self) -> dict[str, Any]:
        """Its keys that span the grid, with their values as in the dataset."""
        values = {key: value for key, value in self.keys if key in self.spanned}
        plain = {key: isinstance(value, int | float) and not isinstance(value, bool) for key, value in values.items()}
        return {key: value if plain[key] else text_of(value) for key, value in values.items()}

    @property
    def title(self) -> str:
        """The text in the dataset, with the keys that span the grid: `small-world neighbours=4`."""
        return " ".join([str(self), *(f"{key}={text_of(value)}" for key, value in self.parameters.items())])
