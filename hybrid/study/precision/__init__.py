"""Speed against accuracy: problems with known answers, each run over its methods and parameters."""
