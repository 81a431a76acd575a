"""A recording of robots whose logs grow while they are watched."""

import json

ROUNDS = 40


class Recording:
    """A copy of a day whose logs grow as a test wants."""

    def __init__(self, whole, folder):
        self.folder, self.about = folder, json.loads((whole / "swarm.json").read_text())
        self.about.pop("sha256", None)
        folder.mkdir()
        (folder / "brain.py").write_bytes((whole / "brain.py").read_bytes())
        self.contents = {path.name: path.read_bytes() for path in whole.glob("*.log")}
        self.grow(0.0)
        self.tell({"ended": None, "result": {}})

    def tell(self, change):
        (self.folder / "swarm.json").write_text(json.dumps(self.about | change))

    def grow(self, share):
        """All logs have at least this share of their bytes now; one that begins late begins late here, too."""
        for name, content in self.contents.items():
            begins = 0.6 if name == "robot-3.log" else 0.0
            size = max(200 if not begins else 0, int(len(content) * (share - begins) / (1.0 - begins)))
            if size > 0:
                with (self.folder / name).open("ab") as log:
                    log.write(content[log.tell() : size])
