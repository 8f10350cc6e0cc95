"""The solution of the least-squares problem, its start and its covariance."""
