"""The robot arm of the paper: every printed number beside the recomputed one."""
