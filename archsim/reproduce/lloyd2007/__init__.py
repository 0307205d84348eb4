"""Lloyd, Govindaraju, Molnar, Manocha 2007, Practical logarithmic rasterization for low-error shadow maps.

The paper prints few numbers: those are compared; its curves and pictures are measured on stand-in scenes.
"""

from archsim.reproduce.lloyd2007.tables import PAPER, reproduce
from archsim.reproduce.lloyd2007.views import ID

__all__ = ["ID", "PAPER", "reproduce"]
