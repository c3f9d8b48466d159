"""``nox`` runs the tests under every supported Python that is installed here."""

import nox

nox.options.error_on_missing_interpreters = False


@nox.session(python=["3.11", "3.12", "3.13"])
def tests(session: nox.Session) -> None:
    """Install as the README says, and run the tests."""
    session.install(".[test]")
    session.run("pytest", *session.posargs)


@nox.session(default=False)
def links(session: nox.Session) -> None:
    """Follow the links to other sites in all texts, without running the examples; this needs a network."""
    session.install(".[docs]")
    without_examples = ["-D", "plot_gallery=0", "-D", "nb_execution_mode=off"]
    build = ["sphinx-build", "-q", "-W", "-t", "links", "-b", "linkcheck", *without_examples, "-c", "docs"]
    session.run(*build, ".", "build/links")
