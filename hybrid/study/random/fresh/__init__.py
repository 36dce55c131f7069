"""Problems set up afresh, by kind: `hybrid.study.random.afresh` has their table and runs them."""
