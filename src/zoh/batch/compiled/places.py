"""What Python and compiled code agree on: laws by number, and figures by their places in a row."""

CODES = {"p": 0, "pi": 1, "pd": 2, "pid": 3, "lag": 4, "lead": 5, "given": 6}
PID, GIVEN = CODES["pid"], CODES["given"]
GAINS = 4  # at most, of a law

GM, PHASE_CROSSOVER, PM, CROSSOVER, DELAY, MODULUS, MS, MT, DISK, BANDWIDTH = range(10)
MARGINS = 10

(
    OVERSHOOT, RISE, SETTLING, PEAK, PEAK_TIME, ERROR, EFFORT, BETWEEN_OVERSHOOT, BETWEEN_TIME,
) = range(9)  # fmt: skip
STEPS = 9
