"""What goes wrong through bad input, said in one sentence for a person."""


class InputError(ValueError):
    """Bad input: the message names the file, the key, the value and what would be right."""


class Interrupted(KeyboardInterrupt):
    """A run was stopped by Ctrl-C; `results` holds the dataset with the trials that were done."""

    def __init__(self, results: object, done: int, total: int) -> None:
        """Keep the partial dataset and how far it got."""
        super().__init__(f"stopped after {done} of {total} trials")
        self.results = results
        self.done = done
        self.total = total
