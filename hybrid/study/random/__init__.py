"""Problems drawn at random, with nothing set but the physics: does the program get them right by default?"""
