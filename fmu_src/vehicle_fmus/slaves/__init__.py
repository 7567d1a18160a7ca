"""What runs inside an FMU, beside `suspension`: one thin script per model, and what they share."""
