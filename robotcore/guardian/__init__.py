"""The guardian: a process that outlives the app's, and stops the motors where a thread of the app's could not.

Here is what a driver needs to have its motors stopped so. Nothing heavy is imported with it: the guardian starts fast.
"""

from robotcore.guardian.cutoff import Cutoff, CutoffSpec, Unsure

__all__ = ["Cutoff", "CutoffSpec", "Unsure"]
