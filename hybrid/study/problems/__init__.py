"""Problems with a known answer, each with the curves that a study draws of it (contract in hybrid.study.sweep)."""
