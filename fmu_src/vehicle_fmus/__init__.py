"""FMI 2.0 co-simulation FMUs of the models of `suspension`: `build.build` packs them."""
