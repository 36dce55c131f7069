"""Problems with a known answer, each with the curves that a study draws of it (the contract is in hybrid.study.sweep)."""
