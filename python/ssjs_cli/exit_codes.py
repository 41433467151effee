"""How a call of the program ends."""

DONE = 0
OUR_FAULT = 1
USER_ERROR = 2
PARTLY_DONE = 3
INTERRUPTED = 130
