"""Files that gmsh may read for a geometry, and the statements that their text may not have.

A .geo file is a program: it can start others, read and write files, and wait for ever. One that describes a body needs
none of this, so such statements are refused where they stand, before gmsh sees the file, even in a branch that is not
taken. gmsh itself runs confined (`hybrid.runtime.sandbox`); the checks here give the reason, and hold alone where a
system cannot confine. Text is split as gmsh 4 does it: names have case, strings have no escapes.
"""

import re

from hybrid.runtime.errors import GeometryError

MESH_HEADS = (b"$MeshFormat", b"$Comments", b"$NOD")   # gmsh takes any other .msh file for a program
SOLIDS = (".step", ".stp", ".iges", ".igs", ".brep")   # files of CAD
SUFFIXES = (".geo", ".msh", ".stl", *SOLIDS)
LARGEST, LONGEST_TEXT, MOST = 200_000_000, 4_000_000, 100   # [bytes] of all files, of a .geo file; number of files
REASONS = {
    **dict.fromkeys(("SystemCall", "System", "NonBlockingSystemCall", "SendToServer", "ExternalProcess"),
                    "starts another program"),
    **dict.fromkeys(("Save", "Print", "CreateDir"), "writes a file"),
    **dict.fromkeys(("GetEnv", "FileExists", "ListFromFile"), "looks at the machine outside the geometry"),
    **dict.fromkeys(("Exit", "Abort"), "ends gmsh"),
    **dict.fromkeys(("Plugin",), "starts a plugin, which may read and write files"),
    **dict.fromkeys(("StringToName", "S2N"), "makes a name that cannot be checked"),
    "Sleep": "only waits",
}
READERS = ("Merge", "MergeWithBoundingBox", "MergeFile", "Include", "ShapeFromFile")
PRINTERS = ("Printf", "Warning", "Error", "Echo")
OPTIONS = ("General", "PostProcessing", "Print")       # kinds of options; those with texts name files and programs
FILE_OPTIONS = ("FileName", "CommandLine")             # of fields
KERNELS = ("OpenCASCADE", "Built-in")
BRANCH_ENDS = ("EndIf", "EndFor", "Else", "Return")    # where gmsh goes on after text that it skips
LONGEST = 1000                                         # [characters] of a string; beyond 1023 gmsh runs what follows
TOKEN = re.compile(r"""(?P<comment>//[^\n]*|/\*.*?\*/)|(?P<string>"[^"]*"|'[^']*')|(?P<word>[A-Za-z_][A-Za-z0-9_]*)
                       |(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[Ee][-+]?[0-9]+)?)|(?P<mark>\S)""", re.S | re.X)
PLAIN = re.compile(r"[^-./\\][^/\\]*")


def files_of(path):
    """Files that gmsh reads for the geometry at `path`: {name: bytes}, itself first, checked, without comments.

    A geometry reads files of its own folder only, named plainly. Raises GeometryError with line, statement and remedy.
    """
    files = {}
    _add(path, files, ())
    return files


def _add(path, files, readers):
    """Add a file and all that it reads; readers: names of those that lead to it."""
    if path.suffix not in (*SUFFIXES, *map(str.upper, SUFFIXES)):   # gmsh would take an .Stl for a program
        raise GeometryError(f"geometry {path}: files of type '{path.suffix}' are not read, only {', '.join(SUFFIXES)}; "
                            "convert it to one of these")
    if path.name in readers:
        raise GeometryError(f"geometry {path}: reads itself through {', '.join(readers)}; delete one of the statements")
    if path.name in files:
        return
    content = _content(path)
    if sum(map(len, files.values())) + len(content) > LARGEST or len(files) >= MOST:
        raise GeometryError(f"geometry {path}: more than {MOST} files or {LARGEST / 1e6:g} MB, the limits; "
                            "simplify the shape")
    if path.suffix.lower() == ".geo" and len(content) > LONGEST_TEXT:
        raise GeometryError(f"geometry {path}: more than {LONGEST_TEXT / 1e6:g} MB of statements, the limit; "
                            "save the shape as .step or the mesh as .msh, and merge that")
    if path.suffix.lower() == ".msh" and not content.startswith(MESH_HEADS):
        raise GeometryError(f"geometry {path}: is no mesh of gmsh, as it does not begin with $MeshFormat; "
                            "write it anew by `gmsh -3`, or rename it if it is a .geo file")
    if path.suffix.lower() != ".geo":
        files[path.name] = content
        return
    text, named = screened(content.decode("latin-1"), path)
    files[path.name] = text.encode("latin-1")
    for name, line in named:
        beside = path.parent / name
        if beside.resolve().parent != path.parent.resolve() and beside.is_file():
            raise _refusal(path, line, f"reads '{name}', a link out of the geometry's folder", "copy the file there")
        if not beside.is_file():
            raise GeometryError(f"geometry {path}, line {line}: there is no file '{name}' beside it; copy it there")
        _add(beside, files, (*readers, path.name))


def _content(path):
    if not path.is_file():
        raise GeometryError(f"geometry {path} cannot be read: there is no such file; check its name and folder")
    try:
        with open(path, "rb") as file:
            return file.read(LARGEST + 1)
    except OSError as error:
        raise GeometryError(f"geometry {path} cannot be read: {error.strerror}; check its owner and rights") from None


def _refusal(path, line, what, remedy="a geometry only describes a body: delete this statement"):
    return GeometryError(f"geometry {path}, line {line}: {what}, which is refused; {remedy}")


def screened(text, path):
    """Text of a .geo file without its comments, and [(name, line)] of the files that it reads, or GeometryError."""
    tokens, blanked = _split(text, path)
    _refuse_hidden(tokens, path)
    _refuse_redirected(tokens, path)
    named = []
    for i, (kind, word, line) in enumerate(tokens):
        if kind != "word":
            continue
        after = [token[1] for token in tokens[i + 1 : i + 5]] + [""] * 4
        if word in REASONS and after[0] != "=" and (word, after[0]) != ("Print", "."):
            raise _refusal(path, line, f"{word} {REASONS[word]}")
        if word.startswith("Onelab"):
            raise _refusal(path, line, f"{word} starts another program")
        if word in READERS:
            named.append((_plain_name(tokens, i, path), line))
        if word == "SetFactory" and after[1].strip("\"'") not in KERNELS:
            raise _refusal(path, line, f"SetFactory({after[1]}) starts a plugin", 'use SetFactory("OpenCASCADE")')
        if word == "Solver" and after[0] == ".":
            raise _refusal(path, line, f"Solver.{after[1]} is about other programs")
        if word in FILE_OPTIONS and after[0] == "=":
            raise _refusal(path, line, f"{word} names a file or a program")
        if word in OPTIONS and after[0] == "." and after[2] == "=" and not re.match(r"[-+.0-9]", after[3]):
            raise _refusal(path, line, f"{word}.{after[1]} = {after[3]} may name a file or a program",
                           "delete this statement, or give the option as a number")
    return blanked, named


def _split(text, path):
    """Tokens [(kind, text, line)] without comments, and the text with blanks in their place."""
    if "\0" in text:
        raise GeometryError(f"geometry {path}: has NUL characters, so it is no text in UTF-8; save it as such")
    tokens, parts, end, line = [], [], 0, 1
    for found in TOKEN.finditer(text):
        kind, word = found.lastgroup, found.group()
        line += text.count("\n", end, found.start())
        gap = text[end : found.start()]
        if kind == "comment":
            parts += [gap, re.sub(r"[^\n]", " ", word)]
        else:
            tokens.append((kind, word, line))
            parts += [gap, word]
        if kind == "mark" and (word in "\"'" or text.startswith("/*", found.start())):
            raise _refusal(path, line, "a string or comment begins that has no end", "close it")
        if kind == "string" and ("\n" in word or len(word) > LONGEST):
            raise _refusal(path, line, f"a string of several lines, or of more than {LONGEST} characters", "shorten it")
        line += word.count("\n")
        end = found.end()
    return tokens, "".join(parts) + "\n"


def _refuse_hidden(tokens, path):
    """Refuse statements in strings and names, where gmsh finds them: it looks for ends of branches in these too."""
    plain = (*BRANCH_ENDS, "ElseIf")
    doubtful = [token for token in tokens if token[0] in ("string", "word") and token[1] not in plain]
    if not any(end in token[1] for token in doubtful for end in BRANCH_ENDS):
        return
    commands = (*REASONS, *READERS, *PRINTERS, "Onelab", "Solver")
    for kind, word, line in doubtful:
        for command in commands:
            if command in word and (kind == "string" or any(end in word for end in BRANCH_ENDS)):
                raise _refusal(path, line, f"{command} in {word}, where gmsh may take it for a statement,",
                               "reword this string or name")


def _plain_name(tokens, i, path):
    """Name that the statement of token i reads; GeometryError unless it is a plain one, written out."""
    _, word, line = tokens[i]
    rest = [token for token in tokens[i + 1 : i + 3] if token[1] not in "(["]
    kind, name, _ = rest[0] if rest else ("", "", 0)
    name = name[1:-1].encode("latin-1").decode("utf-8", "replace")
    if kind != "string" or not PLAIN.fullmatch(name):
        raise _refusal(path, line, f"{word} reads a file of another folder, or one that is not named plainly",
                       f'copy it beside the geometry and write {word} with its name alone, such as {word} "part.stl";')
    return name


def _refuse_redirected(tokens, path):
    """Refuse printing statements with > or >> outside their brackets."""
    printer, depth = None, 0
    for kind, word, line in tokens:
        if kind == "word" and word in PRINTERS:
            printer, depth = (word, line), 0
        elif kind == "mark":
            depth += (word in "([{") - (word in ")]}")
            if word == ";":
                printer = None
            elif word == ">" and printer and depth <= 0:
                raise _refusal(path, printer[1], f"{printer[0]} with > writes a file")
