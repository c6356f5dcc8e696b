"""The paper's experiment: its studies, their runs and what they gave."""
