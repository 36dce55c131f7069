"""Statements of geometry files that do more than describe a body; {mark} is a file that must never come to be."""

BOX = """SetFactory("OpenCASCADE");
DefineConstant[ size = {0.6, Name "Parameters/size"} ];
Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;
Box(1) = {0, 0, 0, 1, 1, 1};
Physical Volume("body") = {1};
Physical Surface("contact") = Abs(Boundary{ Volume{1}; });
"""
STATEMENTS = {  # the command that the reason names: statements
    "SystemCall": ['SystemCall "touch {mark}";', "SystemCall 'touch {mark}';",
                   'SystemCall\n  /* why */ "touch {mark}" ;',
                   'SystemCall StrCat["touch ", "{mark}"];', 'If (size > 0) SystemCall "touch {mark}"; EndIf',
                   'Macro act\nSystemCall "touch {mark}";\nReturn\nCall act;',
                   'For i In {1:2} /*\nSystemCall "touch {mark}"; // */ SystemCall "touch {mark}";\nEndFor',
                   'x = 1; // */ " \nSystemCall "touch {mark}"; // "', 'y = 1e5;SystemCall "touch {mark}";',
                   'If (0)\n s = " EndIf SystemCall \'touch {mark}\'; // ";\n',
                   'If (0)\nx = EndIf9SystemCall "touch {mark}";\nEndIf'],
    "System": ['System "touch {mark}";'],
    "NonBlockingSystemCall": ['NonBlockingSystemCall "touch {mark}";'],
    "OnelabRun": ['OnelabRun("x", "touch {mark};");', 'OnelabRunInteractive("x", "touch {mark}");'],
    "OnelabReadFromFile": ['OnelabReadFromFile("{mark}");'],
    "SendToServer": ['SendToServer View[0] "touch {mark}";'],
    "ExternalProcess": ['Field[1] = ExternalProcess; Field[1].CommandLine = "touch {mark}"; Background Field = 1;'],
    "Printf": ['Printf("hello") > "{mark}";', 'Printf("%g", (1 > 2)) >> "{mark}";'],
    "Save": ['Save "{mark}.msh";', 'Save View[0] "{mark}";'],
    "Print": ['Print "{mark}.geo_unrolled";', 'Print Str("{mark}.msh");'],
    "CreateDir": ['CreateDir "{mark}";'],
    "Include": ['Include "/etc/passwd";', 'Include "../other.geo";', 'Include StrCat(CurrentDirectory, "x.geo");',
                'Include "missing.geo";'],
    "Merge": ['Merge "/etc/hostname";', 'Merge "~/.bashrc";', 'Merge Sprintf("{mark}");', 'Merge "..";'],
    "ShapeFromFile": ['v() = ShapeFromFile("/etc/hostname");'],
    "GetEnv": ['home = GetEnv("HOME");'],
    "FileExists": ['x = FileExists("/etc/passwd");'],
    "ListFromFile": ['x() = ListFromFile("/etc/passwd");'],
    "Plugin": ['Plugin(NewView).Run;'],
    "S2N": ['S2N["SystemCall"] "touch {mark}";'],
    "Solver": ['Solver.Executable0 = "touch {mark}"; Solver.AutoCheck = 1;'],
    "General": ['General.TextEditor = "touch {mark}";', 'name = "{mark}"; General.LogFileName = name;'],
    "SetFactory": ['SetFactory("Stranger");'],
    "Exit": ["Exit;", "Exit 0;"],
    "Abort": ["Abort;"],
    "Sleep": ["Sleep 1e6;"],
}
CASES = [(command, text) for command, texts in STATEMENTS.items() for text in texts]
LOOPS = {  # without end, which no reading of the text can tell
    "time": "For i In {0:1e15}\n x = i;\nEndFor\n",
    "memory": "x() = {};\nFor i In {0:1e15}\n x() += {0:100000};\nEndFor\n",
    "recursion": "Macro act\nCall act;\nReturn\nCall act;\n",
}


def geometry(path, text, mark):
    """Write a geometry of a box with the statements before it ends; returns its path."""
    path.write_text(BOX + text.replace("{mark}", str(mark)) + "\n")
    return path
