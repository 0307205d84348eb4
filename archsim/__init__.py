"""archsim: a cycle-approximate simulator of graphics-hardware architectures."""

__version__ = "0.1.0"
