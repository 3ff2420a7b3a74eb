"""The same examples on every machine and on every run."""

from hypothesis import HealthCheck, settings

settings.register_profile(
    "zoh", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("zoh")
