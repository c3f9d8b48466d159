"""``nox`` runs the tests under every supported Python that is installed here."""

import nox

nox.options.error_on_missing_interpreters = False


@nox.session(python=["3.11", "3.12", "3.13"])
def tests(session: nox.Session) -> None:
    """Install as the README says, and run the tests."""
    session.install(".[test]")
    session.run("pytest", *session.posargs)
