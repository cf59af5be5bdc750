"""What a configuration leaves out, from the reports and from tracks made of them."""

from trackweave.config.fill import known_sigma, needs_estimates
from trackweave.config.sections import Configuration
from trackweave.domain.reports import ReportTable
from trackweave.estimation import Estimates, estimate

__all__ = ["estimates_for"]


def estimates_for(reports: ReportTable, configuration: Configuration) -> Estimates | None:
    """Return estimates of what a configuration leaves out.

    Parameters
    ----------
    reports
        At least one report.
    configuration
        As read.

    Returns
    -------
    The estimates; None where nothing that can be estimated is left out.
    """
    names = reports.sensors
    if not needs_estimates(configuration, names):
        return None
    return estimate(reports, known_sigma(configuration, names))
