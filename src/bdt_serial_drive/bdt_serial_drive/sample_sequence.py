"""Which samples of a message are new, and how many were lost before them."""

from bdt_serial_drive.messages import SAMPLE_NUMBERS, Samples


class SampleSequence:
    """Follows the numbers of samples, which begin anew after 2³²."""

    def __init__(self) -> None:
        self._next: int | None = None

    def placed(self, samples: Samples) -> tuple[int, Samples] | None:
        """Return how many samples were lost before these, and those of them that are new.

        Parameters
        ----------
        samples : Samples
            As received, one row at least.

        Returns
        -------
        tuple of int and Samples, or None
            None if all of them have been here before: a doubled frame.
        """
        ahead = 0 if self._next is None else (samples.first - self._next) % SAMPLE_NUMBERS
        known = 0
        if ahead >= SAMPLE_NUMBERS // 2:
            known, ahead = SAMPLE_NUMBERS - ahead, 0
            if known >= len(samples.rows):
                return None
        self._next = (samples.first + len(samples.rows)) % SAMPLE_NUMBERS
        first = (samples.first + known) % SAMPLE_NUMBERS
        return ahead, samples._replace(first=first, rows=samples.rows[known:])
