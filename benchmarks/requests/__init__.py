"""Random requests of every law: each is met, or its refusal is right and what it offers is had."""
