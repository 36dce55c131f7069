"""Problems with a known answer, each with the curves that the study draws of it."""
