"""One picture on many machines, by Dask distributed: ``tracer render --workers`` and ``--scheduler``.

The loop stays where it is: rounds are decided by the client. A round is cut into units, pixels with all of their
samples of that round, and drawn by workers. The sums stay with the workers, who go on from them in the next round; what
travels is the counts, one way, and the statistics that decisions are made from, the other. All sums travel once, when
the picture is developed. As samples are keyed, and as those of a pixel are added in their order whoever adds them, the
sums are those of one process, bit for bit, and what is lost with a worker is drawn again.

``setup`` says what a worker must know, ``stage`` is what a worker keeps open, ``unit`` is what it does, ``regions``
cuts up the picture, ``held`` is the estimate whose sums are elsewhere, ``spread`` draws a round, ``crew`` connects.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tracer.session.request import Workers


@contextmanager
def hired(cluster: Any) -> Iterator[Workers | None]:
    """Yield the workers of ``cluster``, see ``tracer.cluster.remote_drawer``, or None, for this process, if it is None.

    Raises ClusterError if Dask is not installed, or no workers can be had.
    """
    if cluster is None:
        yield None
        return
    from tracer.cluster.remote_drawer import hire  # Dask is for who asks for it

    with hire(cluster) as workers:
        yield workers
