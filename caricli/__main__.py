"""`python -m caricli` is the same as `caricli`."""

from caricli.cli import main

if __name__ == "__main__":
    main()
