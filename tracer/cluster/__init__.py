"""One picture on many machines, by Dask distributed: ``tracer render --workers`` and ``--scheduler``.

The loop stays where it is: rounds are decided by the client. A round is cut into units, pixels with all of their
samples of that round, and drawn by workers. The sums stay with the workers, who go on from them in the next round; what
travels is the counts, one way, and the statistics that decisions are made from, the other. All sums travel once, when
the picture is developed. As samples are keyed, and as those of a pixel are added in their order whoever adds them, the
sums are those of one process, bit for bit, and what is lost with a worker is drawn again.

What decides knows neither Dask nor a clock: ``work_balancer`` cuts the picture into regions and deals them out,
``units`` are what a round is cut into, ``work_pool`` keeps some back for whoever is done first, ``round_policy`` says
who is asked for which unit, and for which again. What carries that out: ``connection`` connects, ``messages`` sends
and hears, ``sums_transfer`` moves sums, ``round_scheduler`` draws a round. ``remote_estimate`` is the estimate whose
sums are elsewhere, ``remote_sums`` says where. On workers, ``worker_setup`` is what they must know, ``worker_scene``
what they keep open, ``worker_task`` what they do.
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
    from tracer.cluster.remote_drawer import open_workers  # Dask is for who asks for it

    with open_workers(cluster) as workers:
        yield workers
