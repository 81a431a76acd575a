"""A contract of import-linter: a package is imported by its name, its modules only from inside it.

What others may use of a package, modules too, stands in its `__init__.pyi`. Options: `root`, the package of all
packages; `public`, modules that others may import besides, with all below them.
"""

import importlib

from grimp import ImportGraph
from importlinter import Contract, ContractCheck, fields, output


class Interfaces(Contract):
    """Breaks where a module imports a private module of another package."""

    type_name = "interfaces"
    root = fields.StringField()
    public = fields.ListField(subfield=fields.StringField())

    def check(self, graph: ImportGraph, verbose: bool) -> ContractCheck:
        """Compare all imports with what is public."""
        depth = self.root.count(".") + 1
        broken = []
        for importer in graph.modules:
            for imported in graph.find_modules_directly_imported_by(importer):
                package = imported.split(".")[: depth + 1]
                inside = importer.split(".")[: depth + 1] == package
                if inside or imported.count(".") <= depth:
                    continue
                offered = getattr(importlib.import_module(".".join(package)), "__all__", [])
                public = any(f"{imported}.".startswith(f"{name}.") for name in self.public)
                if not public and ".".join(imported.split(".")[depth + 1 :]) not in offered:
                    broken.append(f"{importer} imports {imported}")
        return ContractCheck(kept=not broken, metadata={"broken": sorted(broken)})

    def render_broken_contract(self, check: ContractCheck) -> None:
        """List the imports."""
        for line in check.metadata["broken"]:
            output.print_error(line)
