"""What is said of what was selected: findings, how sure they are, and what no recording shows."""
