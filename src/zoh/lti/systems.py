"""Plant (continuous) and Sampled (dt): two types that never mix."""

from zoh.lti.plant import Plant
from zoh.lti.sampled import Sampled, sample_time

__all__ = ["Plant", "Sampled", "sample_time"]
