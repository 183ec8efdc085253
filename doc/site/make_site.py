#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The site of ./dev docs: pages from the tree's documents, by mkdocs, and of headers, by doxygen.

    make_site.py stage FOLDER    writes FOLDER/source, FOLDER/mkdocs.yml and FOLDER/Doxyfile
    make_site.py check SITE      each link leads to a file and an anchor, and no page loads anything from another host

Steps of stage: 1. documents, with links to sources turned to pages of these  2. a page for each VTK class: what its header says,
its picture, an example that is built and run in the tests  3. what mkdocs and doxygen are told.
"""
import json
import os
import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

ROOT = Path(__file__).resolve().parents[2]

# Of each class: its header, an example, how that is run.
CLASSES = {
    "vtkKdMeshReader": ("filters/IO", "Stores/MeshInfo.cxx", "MeshInfo statue.ply"),
    "vtkKdTreePartition": ("filters/Partitioning", "PartitionPicture/main.cxx", "PartitionPicture statue.ply partitions.png"),
    "vtkOctreePartition": ("filters/Partitioning", "Classes/ComparePartitions.cxx", "ComparePartitions statue.ply"),
    "vtkKMeansPartition": ("filters/Partitioning", "Classes/ComparePartitions.cxx", "ComparePartitions statue.ply"),
    "vtkPartitionMeasures": ("filters/Partitioning", "Classes/ComparePartitions.cxx", "ComparePartitions statue.ply"),
    "vtkKdClusterSimplification": ("filters/Simplification", "Classes/Coarsen.cxx", "Coarsen statue.ply coarse.ply 20000"),
    "vtkPCLSurfaceReconstruction": ("filters/PointCloud", "Classes/PointsToSurface.cxx", "PointsToSurface cloud.ply surface.ply"),
    "vtkKdStoreWriter": ("filters/IO", "Stores/MakeStore.cxx", "MakeStore sphere.kds"),
    "vtkKdStoreReader": ("viewer/sources", "Stores/StoreGhosts.cxx", "StoreGhosts sphere.kds 4"),
    "vtkKdStreamSource": ("viewer/sources", "Stores/StreamPicture.cxx", "StreamPicture http://127.0.0.1:8700 picture.png"),
    "vtkKdTextureReader": ("viewer/sources", "Classes/TexturedPartition.cxx", "TexturedPartition statue.kds 0"),
    "vtkKdStreamActor": ("viewer/actor", "StreamViewer/StreamViewer.cxx", "StreamViewer http://127.0.0.1:8700"),
    "vtkKdOffscreenRendering": ("viewer/offscreen", "Offscreen/main.cxx", "SpherePicture sphere.png"),
}
# The example's baseline, where a class has no picture of its own.
OTHER_PICTURES = {"vtkKdOffscreenRendering": "viewer/actor/Testing/Data/Baseline/TestKdStreamActorPicture.png"}

MENU = [
    ("Home", "README.md"),
    ("Tutorials", ["serve-your-scan", "guard-it", "filters-in-a-pipeline", "offscreen-pictures", "embed", "client-in-60-lines"]),
    ("Use it", ["cli", "viewing", "embedding", "3dtiles", "benchmarks"]),
    ("Serve it", ["museum", "serving", "security", "SECURITY.md"]),
    ("VTK", ["from-vtk", "classes", "offscreen", "paraview", "api"]),
    ("Formats", ["formats", "protocol"]),
    ("Promises", ["compatibility", "platforms"]),
    ("Inside", ["newcomers", "architecture", "design", "decisions", "CONTRIBUTING.md", "CHANGELOG.md"]),
]
LANGUAGES = {".cxx": "cpp", ".h": "cpp", ".mjs": "js", ".js": "js", ".html": "html", ".txt": "cmake", ".cff": "yaml", ".conf": "nginx"}


def anchor_of(heading):
    """As GitHub makes it (Testing/Documents/References.cxx)."""
    text = re.sub(r"\]\([^)]*\)", "", heading)
    return "".join("-" if c == " " else c.lower() for c in text.rstrip() if c == " " or c in "-_" or c.isalnum())


def outside_code(text, change):
    """Applies `change` to each stretch of text that is no block of code."""
    parts = re.split(r"(^```.*?^```[^\n]*$)", text, flags=re.M | re.S)
    return "".join(part if i % 2 else change(part) for i, part in enumerate(parts))


def home(path):
    """Where a file of the tree lies in the site's source."""
    return "index.md" if path == "README.md" else path


class Staging:
    def __init__(self, folder):
        self.source = folder / "source"
        self.staged = set()
        self.waiting = []

    def want(self, path):
        """The staged path of a file or folder of the tree that a page links to."""
        if (ROOT / path).is_dir():
            target = f"{path.rstrip('/')}/index.md"
        elif path.endswith((".png", ".svg", ".webp", ".jpg")):
            target = path
        elif path.endswith(".md"):
            target = home(path)
        else:
            target = f"{path}.md"
        if target not in self.staged:
            self.staged.add(target)
            self.waiting.append((path, target))
        return target

    def run(self):
        while self.waiting:
            path, target = self.waiting.pop()
            origin = ROOT / path
            if target == path and not path.endswith(".md"):
                self.write_bytes(target, origin.read_bytes())
            elif origin.is_dir():
                self.write(target, self.folder_page(path))
            elif path.endswith(".md"):
                self.write(target, self.page(path, target, origin.read_text("utf8")))
            else:
                self.write(target, self.source_page(path))

    def write(self, target, text):
        self.write_bytes(target, text.encode("utf8"))

    def write_bytes(self, target, content):
        file = self.source / target
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)

    def source_page(self, path, depth=1):
        text = (ROOT / path).read_text("utf8")
        language = LANGUAGES.get(Path(path).suffix, "")
        return f"{'#' * depth} {Path(path).name if depth > 1 else path}\n\n~~~~{language}\n{text}~~~~\n"

    def folder_page(self, path):
        if path.rstrip("/") == "doc/decisions":
            lines = []
            for file in sorted((ROOT / path).glob("*.md")):
                title = file.read_text("utf8").split("\n", 1)[0].lstrip("# ")
                self.want(f"doc/decisions/{file.name}")
                lines.append(f"- [{title}]({file.name})")
            return "# Decisions\n\nChoices that are hard to undo: context, choice, cost.\n\n" + "\n".join(lines) + "\n"
        pages = [f"# {path}\n"]
        for file in sorted((ROOT / path).rglob("*")):
            name = file.relative_to(ROOT).as_posix()
            if file.is_file() and (file.suffix in LANGUAGES or file.suffix == "") and "Testing/" not in name[len(path):]:
                pages.append(self.source_page(name, 2).replace(f"## {file.name}", f"## {file.relative_to(ROOT / path).as_posix()}", 1))
        return "\n".join(pages)

    def page(self, path, target, text):
        """A document as Python-Markdown wants it: anchors as GitHub's, links to what is staged."""
        here = Path(path).parent

        def link(match):
            words, where = match.group(1), match.group(2)
            if re.match(r"[a-z]+:", where) or where.startswith("#"):
                return match.group(0)
            file, _, anchor = where.partition("#")
            goal = self.want(os.path.normpath(here / file).replace(os.sep, "/"))
            relative = os.path.relpath(goal, Path(target).parent).replace(os.sep, "/")
            return f"[{words}]({relative}{'#' + anchor if anchor else ''})"

        def change(part):
            part = re.sub(r"\[((?:!\[[^\]]*\]\([^)]*\)|[^\]])*)\]\(([^)\s]+)\)", link, part)
            part = re.sub(r"^(##+) (.*?) *$", lambda m: f"{m.group(1)} {m.group(2)} {{#{anchor_of(m.group(2))}}}", part, flags=re.M)
            # What belongs to an item of a list is indented by four for each list, where GitHub takes two or three too.
            part = re.sub(r"^ +(?=\S)", lambda m: " " * {2: 4, 3: 4, 5: 8, 6: 8, 7: 8}.get(len(m.group(0)), len(m.group(0))), part, flags=re.M)
            # A list begins after an empty line.
            part = re.sub(r"(?m)^(?! *(?:[-*]|\d+\.) )( *\S.*\n)(?= *(?:[-*]|\d+\.) )", r"\1\n", part)
            # Bars in code stay in their cell.
            return re.sub(r"^\|.*$", lambda m: re.sub(r"`[^`]*`", lambda c: c.group(0).replace("\\|", "|"), m.group(0)), part, flags=re.M)

        return outside_code(text, change)


def class_text(header, name):
    """The first comment of a VTK class's header: its brief, and the rest as it stands."""
    comment = re.search(r"/\*\*(.*?)\*/", header, re.S).group(1)
    lines = [re.sub(r"^ \* ?", "", line) for line in comment.split("\n")]
    text = "\n".join(lines).strip()
    brief = re.search(r"@brief\s+(.*?)(?:\n\n|$)", text, re.S).group(1).replace("\n", " ")
    body = text[text.index("@brief"):].split("\n\n", 1)[1] if "\n\n" in text[text.index("@brief"):] else ""
    body = re.sub(r"@code(.*?)@endcode", r"```cpp\1```", body.replace("@sa ", "See also: "), flags=re.S)
    return brief.strip(), body


def stage_classes(staging):
    lines = ["# Classes", "", "Each page has what the header says, a picture, and an example that the tests build and run.", "", "| | |", "|---|---|"]
    for name, (folder, example, command) in CLASSES.items():
        brief, body = class_text((ROOT / folder / f"{name}.h").read_text("utf8"), name)
        picture = staging.want(OTHER_PICTURES.get(name, f"doc/pictures/vtk/{name}.png"))
        project = Path(example).parent.as_posix()
        staging.want(f"Examples/{project}")
        pages = {other: f"[{other}]({other}.md)" for other in CLASSES}
        pages |= {base: f"[{base}](../../headers/class{base}.html)" for base in ("vtkMeshPartition", "vtkKdModelSource")}
        pages[name] = f"`{name}`"
        known = re.compile(rf"(?<![\w`])({'|'.join(pages)})(?!\w)")
        body = outside_code(body, lambda part: known.sub(lambda m: pages[m.group(1)], part))
        text = (ROOT / "Examples" / example).read_text("utf8")
        page = f"""# {name}

![{name}](../../{picture})

{brief[0].upper() + brief[1:]}. Module `KdStream::{"".join(part[0].upper() + part[1:] for part in folder.split("/"))}`;
[all members](../../headers/class{name}.html).

## Example

    {command}

~~~~cpp
{text}~~~~

Its project: [Examples/{project}](../../Examples/{project}/index.md).

## What the header says

{body}
"""
        staging.write(f"doc/classes/{name}.md", page)
        lines.append(f"| ![{name}](../../{picture}) | [{name}]({name}.md): {brief} |")
    staging.write("doc/classes/index.md", "\n".join(lines) + "\n")


def menu(staging):
    entries = []
    for title, pages in MENU:
        if isinstance(pages, str):
            entries.append({title: staging.want(pages)})
            continue
        below = []
        for page in pages:
            if page == "classes":
                below.append({"Classes": ["doc/classes/index.md"] + [f"doc/classes/{name}.md" for name in CLASSES]})
            elif page == "decisions":
                below.append({"Decisions": staging.want("doc/decisions")})
            elif page.endswith(".md"):
                below.append(staging.want(page))
            else:
                folder = "doc/tutorials" if title == "Tutorials" else "doc"
                below.append(staging.want(f"{folder}/{page}.md"))
        entries.append({title: below})
    return entries


def doxyfile(folder):
    """Headers of the API: those that doc/api.md names."""
    headers = re.findall(r"^\| `([\w/]+\.h)`", (ROOT / "doc/api.md").read_text("utf8"), re.M)
    macros = [
        "vtkTypeMacro(a,b)=", "vtkAbstractTypeMacro(a,b)=", "VTK_FILEPATH=", "VTK_NEWINSTANCE=",
        "vtkSetMacro(n,t)=virtual void Set##n(t);", "vtkGetMacro(n,t)=virtual t Get##n();",
        "vtkSetClampMacro(n,t,a,b)=virtual void Set##n(t);", "vtkBooleanMacro(n,t)=virtual void n##On(); virtual void n##Off();",
        "vtkSetFilePathMacro(n)=virtual void Set##n(const char*);", "vtkGetFilePathMacro(n)=virtual char* Get##n();",
        "vtkSetStringMacro(n)=virtual void Set##n(const char*);", "vtkGetStringMacro(n)=virtual char* Get##n();",
        "vtkSetStdStringFromCharMacro(n)=virtual void Set##n(const char*);", "vtkGetCharFromStdStringMacro(n)=virtual const char* Get##n();",
        "vtkGetObjectMacro(n,t)=virtual t* Get##n();",
        "vtkSetVector2Macro(n,t)=virtual void Set##n(t, t);", "vtkGetVector2Macro(n,t)=virtual t* Get##n();",
        "vtkSetVector3Macro(n,t)=virtual void Set##n(t, t, t);", "vtkGetVector3Macro(n,t)=virtual t* Get##n();",
    ]
    for header in headers:
        macros += [f"{word}=" for word in re.findall(r"\b(VTKKDSTREAM\w+_EXPORT)\b", (ROOT / header).read_text("utf8"))[:1]]
    settings = {
        "PROJECT_NAME": "KdStream", "OUTPUT_DIRECTORY": folder / "site", "HTML_OUTPUT": "headers", "GENERATE_LATEX": "NO",
        "INPUT": " ".join(str(ROOT / header) for header in headers), "STRIP_FROM_PATH": ROOT, "EXTRACT_ALL": "YES", "QUIET": "YES",
        "WARNINGS": "NO", "WARN_IF_UNDOCUMENTED": "NO", "WARN_IF_DOC_ERROR": "NO", "HAVE_DOT": "NO", "SEARCHENGINE": "YES", "VERBATIM_HEADERS": "NO",
        "JAVADOC_AUTOBRIEF": "YES", "MACRO_EXPANSION": "YES", "EXPAND_ONLY_PREDEF": "YES", "MARKDOWN_SUPPORT": "NO",
        # Comments of libraries are plain ones: the first is the file's, each other its declaration's.
        "FILTER_PATTERNS": r'''"*.h=sed -E -e '1s#^// SPDX.*#/// \\file#' -e 's#^([ ]*)// #\1/// #'"''',
        "PREDEFINED": " ".join(f'"{macro}"' for macro in dict.fromkeys(macros)),
    }
    return "".join(f"{key} = {value}\n" for key, value in settings.items())


def stage(folder):
    staging = Staging(folder)
    stage_classes(staging)
    entries = menu(staging)
    staging.run()
    index = staging.source / "index.md"
    index.write_text(index.read_text("utf8").replace("## Why", "**[Open the demo](demo/index.html)**: three models as plain files, nothing but GET.\n\n## Why", 1), "utf8")
    staging.write("wide.css", "td code, li code, p code { overflow-wrap: break-word; white-space: normal; }\n")
    (folder / "mkdocs.yml").write_text(json.dumps({
        "site_name": "KdStream", "docs_dir": "source", "site_dir": "site", "use_directory_urls": False,
        "theme": {"name": "mkdocs", "highlightjs": False, "nav_style": "light"}, "plugins": ["search"], "nav": entries, "extra_css": ["wide.css"],
        "markdown_extensions": ["attr_list", "tables", "fenced_code", {"toc": {"permalink": True}}],
    }, indent=1), "utf8")
    (folder / "Doxyfile").write_text(doxyfile(folder), "utf8")


class Page(HTMLParser):
    LOADED = {"img": "src", "script": "src", "iframe": "src", "source": "src", "link": "href", "embed": "src", "object": "data"}

    def __init__(self, text):
        super().__init__()
        self.anchors, self.links, self.loaded = set(), [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        for name in ("id", "name"):
            if values.get(name):
                self.anchors.add(values[name])
        if tag == "a" and values.get("href"):
            self.links.append(values["href"])
        loaded = values.get(self.LOADED.get(tag, ""))
        if loaded and not (tag == "link" and values.get("rel") == "canonical"):
            self.loaded.append(loaded)


def check(site):
    pages = {}
    wrong = []

    def page(file):
        if file not in pages:
            pages[file] = Page(file.read_text("utf8", errors="replace"))
        return pages[file]

    for file in sorted(site.rglob("*.html")):
        name = file.relative_to(site)
        if name.parts[0] == "demo" or name.name == "404.html":
            continue
        for where in page(file).links + page(file).loaded:
            url = urlsplit(where)
            if url.scheme or url.netloc:
                if where in page(file).loaded and url.scheme not in ("data", "javascript"):
                    wrong.append(f"{name}: loads {where}")
                continue
            goal = (file.parent / unquote(url.path)).resolve() if url.path else file
            if goal.is_dir():
                goal = goal / "index.html"
            if not goal.is_file():
                wrong.append(f"{name}: {where}: there is no such file")
            elif name.parts[0] == "headers" and url.fragment == "nested-classes":
                continue  # doxygen 1.9.4 links to it where all of them are private
            elif url.fragment and goal.suffix == ".html" and unquote(url.fragment) not in page(goal).anchors:
                wrong.append(f"{name}: {where}: there is no such anchor")
    for file in sorted(site.rglob("*.css")):
        for where in re.findall(r"(?:url\(|@import\s+)['\"]?(https?:[^'\")]+|//[^'\")]+)", file.read_text("utf8", errors="replace")):
            wrong.append(f"{file.relative_to(site)}: loads {where}")
    for each in wrong:
        print(each, file=sys.stderr)
    print(f"{len(pages)} pages, {len(wrong)} wrong links")
    return 1 if wrong else 0


def main(words):
    if len(words) == 2 and words[0] == "stage":
        stage(Path(words[1]).resolve())
        return 0
    if len(words) == 2 and words[0] == "check":
        return check(Path(words[1]).resolve())
    print(__doc__, file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
