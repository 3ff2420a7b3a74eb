"""zoh: digital controllers that provably meet their specification."""

__version__ = "0.1.0"
