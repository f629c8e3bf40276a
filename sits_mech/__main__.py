"""`python -m sits_mech` is the command `sits-mech`."""

from sits_mech.cli.main import main

if __name__ == "__main__":
    main()
