"""Newton's method, control of the increment, and the outer step."""
