"""``python -m studies.paper``: `studies.paper.write`."""

from studies.paper.write import main

if __name__ == "__main__":
    main()
