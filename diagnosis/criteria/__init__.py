"""What a model gains over another one: scores, evidence, cross-validation, equivalence."""
