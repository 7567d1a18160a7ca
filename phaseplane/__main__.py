"""The command line as `python -m phaseplane`."""

from phaseplane.scenarios.cli import main

if __name__ == "__main__":
    main()
