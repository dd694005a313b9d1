"""Whether layers can be glued, as a question to a SAT solver whose answer is checked: a proof step by step, or a model."""
