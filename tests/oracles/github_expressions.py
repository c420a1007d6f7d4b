"""Expressions of GitHub Actions, as far as action.yml and docs/suites.md use them: names, strings, !, ==, !=, &&, || and status functions.

Types are not converted: && and || take booleans, == and != take two strings. Whatever else occurs is an error.
"""

import re

TOKEN = re.compile(r"\s*(?:(?P<operator>\|\||&&|==|!=|!|\(|\))|'(?P<string>(?:[^']|'')*)'"
                   r"|(?P<name>[A-Za-z_][\w-]*(?:\.[A-Za-z_][\w-]*)*)(?P<call>\(\))?)")
STATUS_FUNCTIONS = ("success", "failure", "always", "cancelled")


class ExpressionError(Exception):
    pass


def tokens_of(text):
    tokens, position, text = [], 0, text.strip()
    while position < len(text):
        match = TOKEN.match(text, position)
        if not match:
            raise ExpressionError(f"{text}: unknown syntax at column {position + 1}")
        position = match.end()
        if match["operator"]:
            tokens.append(("operator", match["operator"]))
        elif match["name"]:
            tokens.append(("call" if match["call"] else "name", match["name"]))
        else:
            tokens.append(("string", match["string"].replace("''", "'")))
    return tokens


class Parser:
    """Recursive descent over the tokens of one expression; `contexts` maps the first word of names to nested dictionaries."""

    def __init__(self, text, contexts, has_failed):
        self.text, self.contexts, self.has_failed = text, contexts, has_failed
        self.tokens = tokens_of(text)

    def value(self):
        value = self.either()
        if self.tokens:
            raise ExpressionError(f"{self.text}: unexpected {self.tokens[0][1]}")
        return value

    def takes(self, *operators):
        if self.tokens and self.tokens[0][0] == "operator" and self.tokens[0][1] in operators:
            return self.tokens.pop(0)[1]
        return None

    def expect(self, value, kind):
        if not isinstance(value, kind):
            raise ExpressionError(f"{self.text}: {value!r} is no {kind.__name__}")
        return value

    def either(self):
        value = self.both()
        while self.takes("||"):
            right = self.both()
            value = self.expect(value, bool) | self.expect(right, bool)
        return value

    def both(self):
        value = self.compared()
        while self.takes("&&"):
            right = self.compared()
            value = self.expect(value, bool) & self.expect(right, bool)
        return value

    def compared(self):
        value = self.single()
        operator = self.takes("==", "!=")
        if not operator:
            return value
        # Strings are compared without regard to case.
        left, right = (self.expect(side, str).lower() for side in (value, self.single()))
        return (left == right) == (operator == "==")

    def single(self):
        if self.takes("!"):
            return not self.expect(self.single(), bool)
        if self.takes("("):
            value = self.either()
            if not self.takes(")"):
                raise ExpressionError(f"{self.text}: a parenthesis is not closed")
            return value
        if not self.tokens:
            raise ExpressionError(f"{self.text}: ends too early")
        kind, word = self.tokens.pop(0)
        if kind == "string":
            return word
        if kind == "call":
            return self.status(word)
        if kind == "name":
            return self.named(word)
        raise ExpressionError(f"{self.text}: unexpected {word}")

    def status(self, name):
        if name not in STATUS_FUNCTIONS:
            raise ExpressionError(f"{self.text}: unknown function {name}")
        return {"success": not self.has_failed, "failure": self.has_failed, "always": True, "cancelled": False}[name]

    def named(self, name):
        value = self.contexts
        for word in name.split("."):
            if not isinstance(value, dict) or word not in value:
                raise ExpressionError(f"{self.text}: unknown name {name}")
            value = value[word]
        return value if isinstance(value, (bool, dict)) else str(value)


def filled(text, contexts, has_failed=False):
    """The text with the values of its expressions in their places."""
    def value(match):
        value = Parser(match[1], contexts, has_failed).value()
        if isinstance(value, dict):
            raise ExpressionError(f"{match[1]}: is no value")
        return str(value).lower() if isinstance(value, bool) else value
    return re.sub(r"\$\{\{(.*?)\}\}", value, str(text))


def condition(text, contexts, has_failed):
    """The value of an `if`. Without a status function it holds only where nothing has failed."""
    if text is None:
        return not has_failed
    text = str(text).strip()
    if text.startswith("${{") and text.endswith("}}"):
        text = text[3:-2]
    value = Parser(text, contexts, has_failed).value()
    if not isinstance(value, bool):
        raise ExpressionError(f"{text}: is no condition")
    has_status = any(kind == "call" for kind, _ in tokens_of(text))
    return value and (has_status or not has_failed)
