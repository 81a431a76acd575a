"""Graphs in files of other programs: GraphML, GML, GEXF.

Each reader makes a `_Graph`, in which nodes have the order of the file. No reader makes more than the file holds,
whatever number of nodes it claims. networkx reads GML; of GraphML it drops nodes in groups and the ways of edges.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from swarmcensus.support.errors import TableError
from swarmcensus.support.files import content
from swarmcensus.support.formatting import counted
from swarmcensus.support.texts import read_text
from swarmcensus.worlds.generators import refuse_weights

MOST_BYTES = 500_000_000
FORMATS = {".graphml": "GraphML", ".gml": "GML", ".gexf": "GEXF"}
PAJEK = ".net"
TIMES = {"start", "startopen", "end", "endopen", "timestamp", "timestamps", "intervals"}  # of nodes and edges in GEXF
GML_PARTS = re.compile(r'"[^"]*"|#.*|([^"#]+)')  # texts in quotes, comments and the rest
WAYS = {"directed": True, "true": True, "1": True} | dict.fromkeys(("undirected", "mutual", "false", "0", ""), False)
NO_WEIGHTS = {"graphics", "labelgraphics", "edgeanchor"}  # the looks of links in GML
TABLE = "a table source,target has what is right"


class FileEdges(NamedTuple):
    """The edges of a file: pairs of robots; of a directed one, the second hears the first."""

    pairs: Sequence[tuple[int, int]]
    directed: bool
    nodes: int | None = None  # how many there are, if the file says


class _Edge(NamedTuple):
    ends: tuple[str, str]  # what the file calls its nodes
    one_way: bool
    attributes: list[tuple[str, str]]  # of a name there may be several
    is_drawn_so: bool = True  # False: yEd draws it with other arrows than one at its target


class _Graph(NamedTuple):
    nodes: Mapping[str, str]  # how edges refer to each node, and its name
    edges: list[_Edge]


def is_graph(path: str | Path) -> bool:
    """Whether a file has the ending of one of these formats."""
    return Path(path).suffix.lower() in {*FORMATS, PAJEK}


def read_graph(path: Path, ignore_weights: bool, directed: bool | None = None) -> FileEdges:
    """Read a graph. Nodes 0 to n - 1 are the robots of these numbers; others are numbered in the file's order.

    `directed` is what the study says of its edges, if it does. Raises InputError.
    """
    if path.suffix.lower() == PAJEK:
        made = f"networkx.write_graphml(networkx.read_pajek({str(path)!r}), {str(path.with_suffix('.graphml'))!r})"
        raise TableError.of(path, f"Pajek's files are not read: {made} makes GraphML of it, with the same links")
    kind = FORMATS[path.suffix.lower()]
    try:
        if kind in ("GraphML", "GEXF"):  # XML says itself how it is encoded
            graph = _xml(content(path, MOST_BYTES), kind)
        else:
            graph = _gml(read_text(path, kind=TableError, most=MOST_BYTES))
    except TableError:
        raise
    except (OSError, ValueError, SyntaxError) as error:  # a SyntaxError is XML's
        what = getattr(error, "strerror", None) or error
        raise TableError.of(path, f"cannot be read as {kind}: {what}") from None
    try:
        for edge in () if ignore_weights else graph.edges:
            refuse_weights((key, _number(value)) for key, value in edge.attributes)
    except ValueError as error:
        raise TableError.of(path, f'{error}; weights = "ignore" reads the file without them') from None
    names = list(graph.nodes.values())
    own = {*names} == {*map(str, range(len(names)))}
    number = {node: int(name) if own else k for k, (node, name) in enumerate(graph.nodes.items())}
    pairs = [(number[a], number[b]) for (a, b), *_ in graph.edges]
    one_way = any(edge.one_way for edge in graph.edges)
    if directed is not False and (others := sum(edge.one_way and not edge.is_drawn_so for edge in graph.edges)):
        drawn = f"yEd draws {others:,} of {counted(len(graph.edges), 'link')} with other arrows than one at its target"
        raise TableError.of(path, f"{drawn}: directed = false makes all links go both ways, or else {TABLE}")
    if one_way:
        pairs += [(b, a) for (a, b), edge in zip(pairs, graph.edges, strict=True) if not edge.one_way]
    return FileEdges(pairs, one_way, len(names))


def _number(text: str) -> float | str:
    """The number in a text, which may have a decimal comma, or else the text."""
    try:
        return float(text.replace(",", "."))
    except ValueError:
        return text


def _is_one_way(key: str, value: str) -> bool:
    """Whether a key of an edge or a graph says that links are directed. Raises ValueError if it says neither."""
    if value.strip().lower() not in WAYS:
        raise ValueError(f"{key} = {value[:40]!r}: should be one of {', '.join(filter(None, WAYS))}")
    return WAYS[value.strip().lower()]


def _checked(graph: _Graph, groups: set[str]) -> _Graph:
    """The graph as it is. Raises ValueError for groups of nodes, and for links that lead to no node."""
    if groups:
        raise ValueError(f"node {min(groups)[:40]!r} is a group of nodes: all nodes should be robots, or else {TABLE}")
    for end in (end for edge in graph.edges for end in edge.ends):
        if end not in graph.nodes:
            raise ValueError(f"a link leads to node {end[:40]!r}, which is not there: links should join two nodes")
    return graph


# ---- GraphML and GEXF


def _xml(found: bytes, kind: str) -> _Graph:
    from xml.etree import ElementTree

    root = ElementTree.fromstring(found)
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]  # programs differ in their names of the format's namespace
    if root.tag != kind.lower():
        raise ValueError(f"it has <{root.tag[:40]}> in place of <{kind.lower()}>")
    graphs = root.findall("graph")
    if len(graphs) != 1:
        raise ValueError(f"it has {counted(len(graphs), 'graph')}: one is right, of all robots")
    graph, nodes = graphs[0], list(graphs[0].iter("node"))
    if next(graph.iter("hyperedge"), None) is not None:
        raise ValueError("it has hyperedges: links should join two nodes")
    names = {node.get("id", ""): node.get("id", "") for node in nodes}
    if len(names) < len(nodes):
        raise ValueError("two nodes have one id, or none")
    if kind == "GEXF" and any(TIMES & part.attrib.keys() for part in graph.iter() if part is not graph):
        raise ValueError(f"its nodes or links have times, and links are there all the time: {TABLE}")
    groups = {node.get("id", "") for node in nodes if node.find("graph") is not None or node.find("nodes") is not None}
    groups |= {node.get("pid", "") for node in nodes} & names.keys()
    of_all, of_one = ("edgedefault", "directed") if kind == "GraphML" else ("defaultedgetype", "type")
    default = _is_one_way(of_all, graph.get(of_all, ""))
    declared = [key for key in root.findall("key") if key.get("for", "all") in ("edge", "all")]
    declared += [key for part in graph.findall("attributes") if part.get("class") == "edge" for key in part]
    title = {i: key.get("attr.name") or key.get("title") or i for key in declared for i in [key.get("id", "")]}
    usual = {title[key.get("id", "")]: text for key in declared if (text := key.findtext("default"))}
    edges = []
    for edge in graph.iter("edge"):
        values = [(data.get("key", ""), data.text or "") for data in edge.findall("data")]  # of GraphML
        values += [(data.get("for", ""), data.get("value", "")) for data in edge.findall("attvalues/attvalue")]
        values += [("weight", edge.attrib["weight"])] if "weight" in edge.attrib else []
        attributes = [(title.get(key, key), value) for key, value in values]
        attributes += [item for item in usual.items() if item[0] not in dict(attributes)]
        one_way = _is_one_way(of_one, edge.attrib[of_one]) if of_one in edge.attrib else default
        made = _Edge((edge.get("source", ""), edge.get("target", "")), one_way, attributes)
        if (arrows := edge.find(".//Arrows")) is not None:
            ends = [arrows.get(end, "none") != "none" for end in ("source", "target")]
            made = made._replace(is_drawn_so=ends == [False, True])
        edges.append(made)
    return _checked(_Graph(names, edges), groups)


# ---- GML


def _gml(text: str) -> _Graph:
    import networkx

    text = GML_PARTS.sub(lambda part: part[1].lower() if part[1] else part[0], text)  # keys may have capitals
    if {*re.findall(r"\bdirected\s+(\S+)", GML_PARTS.sub(lambda part: part[1] or '"', text))} - {"0", "1"}:
        raise ValueError("directed should be 0 or 1")
    try:  # as a multigraph, so that a link may be there twice
        graph = networkx.parse_gml(re.sub(r"^\s*graph\s*\[", r"\g<0> multigraph 1 ", text, flags=re.MULTILINE), "id")
    except Exception as error:  # networkx raises many
        raise ValueError(error) from None
    nodes = {str(node): keys for node, keys in graph.nodes(data=True)}
    groups = {node for node, keys in nodes.items() if keys.get("isgroup") == 1 or "graph" in keys}
    labels = {str(keys["label"]): node for node, keys in nodes.items() if "label" in keys}
    names = dict(zip(nodes, labels if len(labels) == len(nodes) else nodes, strict=True))
    of_yed, edges = re.search(r'^[ \t]*creator[ \t]+"yFiles', text, re.MULTILINE) is not None, []
    for *ends, keys in graph.edges(data=True):
        looks = str(keys.get("graphics"))
        drawn_so = not of_yed or ("targetarrow" in looks and "sourcearrow" not in looks)
        edges.append(_Edge((str(ends[0]), str(ends[1])), graph.is_directed(), list(_plain(keys)), drawn_so))
    return _checked(_Graph(names, edges), groups)


def _plain(keys: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """The texts of an edge and of its lists, without those that are no weights."""
    for key, given in keys.items():
        for value in given if isinstance(given, list) else [given]:
            if key not in NO_WEIGHTS:
                yield from _plain(value) if isinstance(value, dict) else [(key, str(value))]
