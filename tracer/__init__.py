"""tracer: adaptive rendering on Mitsuba 3.

Look first with cheap rays, measure how complex what they hit is, and spend the expensive rays where they pay.
"""

from tracer.backend import activate, point_to_library

point_to_library()  # before anything imports Dr.Jit

from tracer import errors  # noqa: E402
from tracer.render import Progress, render  # noqa: E402
from tracer.result import Report, Result  # noqa: E402
from tracer.settings import Settings  # noqa: E402

__all__ = ["Progress", "Report", "Result", "Settings", "activate", "errors", "render"]
