# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of an ensemble: `reading` loads the results, `figures` draws them, `page` writes report.html."""
