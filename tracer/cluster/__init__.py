"""One picture on many machines, by Dask distributed: ``tracer render --workers`` and ``--scheduler``.

The client runs the loop of the render and decides the rounds. It cuts a round into units, which are pixels with all of
their samples of that round, and workers draw them. The sums stay with the workers, which add to them in the next round.
The client sends counts to the workers, and the workers send back the statistics that decisions are made from. All sums
travel once, when the picture is developed. Samples are keyed, and the samples of a pixel are always added in the same
order, so the sums are those of one process, bit for bit. What is lost with a worker is drawn again.

The modules that decide know neither Dask nor a clock: ``work_balancer`` cuts the picture into regions and deals them
out; ``units`` are the pieces of a round; ``work_pool`` keeps some units back for the workers that are done first;
``round_policy`` decides which worker is asked for which unit, and which unit is asked for again. Other modules carry
that out: ``connection`` connects to workers, ``messages`` sends and receives, ``sums_transfer`` moves sums, ``bundle``
sends a scene, ``round_scheduler`` draws a round. ``remote_drawer`` offers all this to a session. ``remote_estimate`` is
the estimate whose sums are on workers, and ``remote_sums`` says where they are. On workers, ``worker_setup`` is what a
worker must know, ``worker_scene`` what it keeps open, ``worker_task`` what it does, ``shield`` what it does first, and
``sums`` are what it keeps.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tracer.session.request import Workers


@contextmanager
def hired(cluster: Any) -> Iterator[Workers | None]:
    """Yield the workers of ``cluster`` (see ``tracer.cluster.remote_drawer``); None, for this process, if it is None.

    Raises ClusterError if Dask is not installed or there are no workers.
    """
    if cluster is None:
        yield None
        return
    from tracer.cluster.remote_drawer import open_workers  # not above, as Dask need not be installed

    with open_workers(cluster) as workers:
        yield workers
