"""Where C++ sources can be mutated by one token, and how.

A tokenizer that relies on the project's format: a binary operator has blanks on both sides, the
brackets of template arguments have none inside. Places are found in the bodies of functions that are
not constexpr; text (statements with string literals, fmt or throw) is left alone.
"""

import bisect
import dataclasses
import re

TOKEN = re.compile(r"""
    (?P<blank>\s+ | //[^\n]* | /\*.*?\*/)
  | (?P<directive>(?<![^\n])[ \t]*\#(?:[^\n\\]|\\.|\\\n)*)
  | (?P<string>(?:u8|[uUL])?(?:R"(?P<raw>[^()\s\\]*)\(.*?\)(?P=raw)"|"(?:[^"\\\n]|\\.)*"))
  | (?P<character>'(?:[^'\\\n]|\\.)+')
  | (?P<number>\.?[0-9](?:[eEpP][+-]|'?[\w.])*)
  | (?P<word>[A-Za-z_]\w*)
  | (?P<operator><=>|<<=|>>=|->\*|\.\.\.|::|->|\+\+|--|[-+*/%&|^!=<>]=|&&|\|\||<<|>>|.)
""", re.VERBOSE | re.DOTALL)

OPENING = {"(": ")", "[": "]", "{": "}"}
CLOSING = frozenset(OPENING.values())

# What ends a term of a sum.
TERM_ENDS = frozenset(", ; ? : + - << >> < <= > >= == != <=> && || & | ^ = += -= *= /=".split())

# A comparison's mutations: the boundary, and the opposite.
COMPARISONS = {"<": ("<=", ">="), "<=": ("<", ">"), ">": (">=", "<="), ">=": (">", "<"),
               "==": ("!=",), "!=": ("==",), "&&": ("||",), "||": ("&&",)}
SIGNS = {"+": "-", "-": "+", "+=": "-=", "-=": "+="}

# Functions whose integer arguments are indices or sizes.
INDEXED = frozenset("block col cols head middleCols middleRows row rows segment tail topLeftCorner "
                    "topRows bottomRows leftCols rightCols column".split())

NOT_A_VALUE = frozenset("return case else do auto const throw co_return".split())


@dataclasses.dataclass(frozen=True)
class Token:
    kind: str
    text: str
    start: int
    end: int


@dataclasses.dataclass(frozen=True)
class Mutation:
    """Replaces [start, end) of a file's text, inside the body [body_start, body_end) of a function
    (both braces included)."""
    start: int
    end: int
    replacement: str
    kind: str  # sign, comparison, term or index
    body_start: int
    body_end: int

    def apply(self, text):
        return text[:self.start] + self.replacement + text[self.end:]


def tokenize(text):
    """The tokens of a text, without blanks, comments and directives."""
    tokens = []
    for match in TOKEN.finditer(text):
        if match.lastgroup == "raw" or match.lastgroup == "string":
            tokens.append(Token("string", match.group(), match.start(), match.end()))
        elif match.lastgroup not in ("blank", "directive"):
            tokens.append(Token(match.lastgroup, match.group(), match.start(), match.end()))
    return tokens


def partners(tokens):
    """The index of the partner of every bracket."""
    found, open_brackets = {}, []
    for i, token in enumerate(tokens):
        if token.kind != "operator":
            continue
        if token.text in OPENING:
            open_brackets.append(i)
        elif token.text in CLOSING:
            start = open_brackets.pop()
            assert OPENING[tokens[start].text] == token.text, "brackets do not match"
            found[start], found[i] = i, start
    assert not open_brackets, "brackets do not match"
    return found


def without_template_parameters(header):
    """A declaration's tokens after template<...>."""
    while header and header[0].text == "template":
        depth, end = 0, 1
        for end in range(1, len(header)):
            depth += {"<": 1, ">": -1, ">>": -2}.get(header[end].text, 0)
            if depth <= 0:
                break
        header = header[end + 1:]
    return header


def function_bodies(tokens, partner):
    """Index pairs of the braces around bodies of functions that are not constexpr."""
    bodies, header, i = [], [], 0
    while i < len(tokens):
        token = tokens[i]
        if token.text in (";", "}"):
            header = []
        elif token.text == ":" and header and header[-1].text in ("public", "private", "protected"):
            header = []
        elif token.text in ("(", "["):
            # Parameters are skipped; what stays says that they were there.
            header.append(token)
            i = partner[i]
            header.append(tokens[i])
        elif token.text == "{":
            words = [t.text for t in without_template_parameters(header)]
            if words and words[0] in ("namespace", "class", "struct", "union", "extern", "inline") and (
                    "(" not in words):
                header = []  # its members follow
            elif "(" not in words or "=" in words[:-1] and "operator" not in words or "enum" in words[:2]:
                header.append(token)  # a value in braces
                i = partner[i]
            elif ":" in words and header[-1].kind == "word" and header[-1].text not in (
                    "const", "noexcept", "override", "final"):
                header.append(token)  # a member's initializer
                i = partner[i]
                header.append(tokens[i])
            else:
                if not {"constexpr", "consteval"} & set(words):
                    bodies.append((i, partner[i]))
                i = partner[i]
                header = []
        else:
            header.append(token)
        i += 1
    return bodies


class Body:
    """Finds the mutations of one function's body."""

    def __init__(self, text, tokens, partner, first, last):
        self.text, self.tokens, self.partner = text, tokens, partner
        self.first, self.last = first, last
        self.boundaries = [i for i in range(first, last + 1) if tokens[i].text in (";", "{", "}")]
        self.found = []

    def blanks_around(self, i):
        token = self.tokens[i]
        return self.text[token.start - 1].isspace() and self.text[token.end].isspace()

    def add(self, first, last, replacement, kind):
        """Replaces the tokens first..last."""
        tokens = self.tokens
        self.found.append(Mutation(tokens[first].start, tokens[last].end, replacement, kind,
                                   tokens[self.first].start, tokens[self.last].end))

    def surroundings(self, i):
        """The tokens between the nearest semicolons or braces around token i."""
        after = bisect.bisect_right(self.boundaries, i)
        end = self.boundaries[after] if after < len(self.boundaries) else self.last
        return self.tokens[self.boundaries[after - 1]:end + 1]

    def is_text(self, i):
        return any(t.kind == "string" or t.text in ("fmt", "throw") for t in self.surroundings(i))

    def is_decided_by_the_compiler(self, i):
        """Inside the parentheses of static_assert or if constexpr."""
        for start, end in self.partner.items():
            if self.first < start < i < end and self.tokens[start].text == "(":
                if self.tokens[start - 1].text in ("static_assert", "constexpr", "decltype", "sizeof"):
                    return True
        return False

    def term_end(self, i):
        """The last token of the term behind the operator i."""
        j = i + 1
        while j <= self.last:
            text = self.tokens[j].text
            if self.tokens[j].kind == "operator" and text in OPENING:
                j = self.partner[j]
            elif text in CLOSING or text in (",", ";"):
                break
            elif j > i + 1 and text in TERM_ENDS and self.blanks_around(j):
                break
            j += 1
        return j - 1

    def statement(self, i):
        """First and last token of the expression statement around i, without its semicolon; none
        where i lies in parentheses."""
        j = i
        while True:
            before = self.tokens[j - 1].text
            if before in (";", "{", "}", "else", "do", ":"):
                break
            if before in ("(", "[", ",", "?", "return"):
                return None
            if before in (")", "]"):
                start = self.partner[j - 1]
                if self.tokens[start - 1].text in ("if", "for", "while", "constexpr"):
                    break
                j = start
            else:
                j -= 1
        end = i
        while self.tokens[end + 1].text != ";":
            end += 1
            if self.tokens[end].text in CLOSING:
                return None
            end = self.partner.get(end, end)
        return j, end

    def find_sign(self, i):
        text = self.tokens[i].text
        if not self.blanks_around(i):
            before = self.tokens[i - 1]
            begins = before.kind == "operator" and before.text not in (")", "]", "}", "++", "--")
            if text == "-" and (begins or before.text == "return"):
                self.add(i, i, "", "sign")
            return
        self.add(i, i, SIGNS[text], "sign")
        if text in ("+", "-"):
            self.add(i, self.term_end(i), "", "term")
        elif statement := self.statement(i):
            self.add(*statement, "static_cast<void>(0)", "term")

    def find_index(self, i):
        before, token, after = self.tokens[i - 1:i + 2]
        following = f"{int(token.text) + 1}" if token.text.isdecimal() else f"{token.text} + 1"
        if before.text == "[" and after.text == "]":
            array, type_name = self.tokens[i - 2], self.tokens[i - 3]
            subscript = array.text in (")", "]") or array.kind == "word" and array.text not in NOT_A_VALUE
            declared = array.kind == "word" and (
                type_name.kind == "word" and type_name.text not in NOT_A_VALUE or
                type_name.text in (">", "&", "*") and not self.blanks_around(i - 3))
            if subscript and not declared:
                self.add(i, i, following, "index")
        elif token.kind == "number" and token.text.isdecimal():
            starts_loop = before.text == "=" and after.text == ";" and (
                "for" in (words := [t.text for t in self.surroundings(i)]) and "double" not in words)
            if starts_loop or self.is_index_argument(i, before, after):
                self.add(i, i, following, "index")

    def is_index_argument(self, i, before, after):
        if before.text not in ("(", ",") or after.text not in (")", ","):
            return False
        while self.tokens[i].text != "(":  # to the call's parenthesis
            i = self.partner[i] if self.tokens[i].text in CLOSING else i
            i -= 1
            if self.tokens[i].text in ("[", "{", ";"):
                return False
        i -= 1
        while self.tokens[i].kind == "number" or self.tokens[i].text in ("<", ">", ","):
            i -= 1
        return self.tokens[i].text in INDEXED

    def mutations(self):
        """Lists of alternatives, one list for each place."""
        places = []
        for i in range(self.first + 1, self.last):
            token = self.tokens[i]
            self.found = []
            if token.kind == "operator" and token.text in SIGNS:
                self.find_sign(i)
            elif token.text in COMPARISONS and self.blanks_around(i):
                for other in COMPARISONS[token.text]:
                    self.add(i, i, other, "comparison")
            elif token.kind in ("number", "word"):
                self.find_index(i)
            if self.found and not self.is_text(i) and not self.is_decided_by_the_compiler(i):
                places.append(self.found)
        return places


def find_places(text):
    """The places of a source text, in order: each a list of mutations of which one may be made."""
    tokens = tokenize(text)
    partner = partners(tokens)
    places = []
    for first, last in function_bodies(tokens, partner):
        places += Body(text, tokens, partner, first, last).mutations()
    return places
