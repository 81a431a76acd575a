"""Topologies: who hears whom."""

import itertools
import re

import matplotlib.text
import networkx as nx
import numpy as np
import pytest
from scipy import stats

import swarmcensus as sc
from swarmcensus.engine.constants import FULL, LISTED, PAIRS
from swarmcensus.support import plugins
from swarmcensus.worlds import is_rs_robust, networks, r_robustness, wiring
from swarmcensus.worlds.chance import Chance
from swarmcensus.worlds.graph_files import FileEdges, read_graph
from swarmcensus.worlds.topologies import random_geometric
from tests.support.small import study_of


def parse(value, tmp_path):
    return networks.parse_topology(value, tmp_path, {})


def graph_of(links, number, robots):
    part = slice(links.starts[number], links.starts[number + 1])
    graph = nx.DiGraph(list(zip(links.senders[part].tolist(), links.receivers[part].tolist(), strict=True)))
    graph.add_nodes_from(range(robots))
    assert nx.reciprocity(graph) == 1 if graph.size() else True
    assert graph.size() == links.starts[number + 1] - links.starts[number]
    return graph.to_undirected()


def links_of(topology, robots, trials=1, first=0):
    return topology.links(robots, 1, first, trials, True, True)


@pytest.mark.parametrize("robots", [1, 2, 3, 10])
@pytest.mark.parametrize(("name", "make"), [("ring", nx.cycle_graph), ("line", nx.path_graph)])
def test_ring_and_line(name, make, robots, tmp_path):
    expected = nx.path_graph(robots) if robots < 3 else make(robots)
    assert nx.utils.graphs_equal(graph_of(links_of(parse(name, tmp_path), robots), 0, robots), expected)


def test_full_uses_sums_where_it_may(tmp_path):
    full = parse("full", tmp_path)
    assert full.links(5, 1, 0, 1, True, True).mode == FULL
    assert full.links(5, 1, 0, 1, False, True).mode == full.links(5, 1, 0, 1, True, False).mode == PAIRS


@pytest.mark.parametrize("robots", [1, 2, 3, 50])
def test_scale_free_is_a_tree(robots, tmp_path):
    links = links_of(parse("scale-free", tmp_path), robots, trials=3)
    assert links.mode == LISTED
    for trial in range(3):
        assert nx.is_tree(graph_of(links, trial, robots))


def test_edge_list_file(tmp_path):
    (tmp_path / "office.csv").write_text("from,to\n0,1\n1,4\n4,1\n")
    topology = parse("office.csv", tmp_path)
    assert (topology.name, topology.edges, topology.directed) == ("office", ((0, 1), (1, 4)), False)
    topology.check(5)
    with pytest.raises(ValueError, match=r"office.csv: edge \(1, 4\).*not there: the robots are numbered 0 to 3"):
        topology.check(4)


def test_a_graphs_own_numbers_are_kept(tmp_path):
    for graph, edges in (
        (nx.Graph([(4, 5), (0, 1)]), ((0, 1), (4, 5))), (nx.DiGraph([(np.int64(3), 2), (0, 1)]), ((0, 1), (3, 2))),
        (nx.Graph([("c", "a"), ("b", "a")]), ((0, 1), (1, 2))), (nx.Graph([(-1, 0)]), ((0, 1),)),
    ):  # fmt: skip
        assert parse(graph, tmp_path).edges == edges


def heard(topology, robots, graph=0):
    links = links_of(topology, robots, graph + 1)
    part = slice(links.starts[graph], links.starts[graph + 1])
    assert (np.diff(links.receivers[part].astype(int) * robots + links.senders[part]) > 0).all()  # as the engine wants
    return set(zip(links.senders[part].tolist(), links.receivers[part].tolist(), strict=True))


ONE_WAY = {(0, 1), (1, 2), (2, 0), (3, 0), (0, 3)}


@pytest.mark.parametrize("kind", ["graph", "list", "array", "file"])
def test_of_a_directed_edge_the_second_hears_the_first(kind, tmp_path):
    rows = sorted(ONE_WAY)
    (tmp_path / "office.csv").write_text("sender,receiver\n" + "".join(f"{u},{v}\n" for u, v in rows))
    value = {
        "graph": nx.DiGraph(rows),
        "list": {"name": "office", "edges": rows + rows[:2], "directed": True},
        "array": {"name": "office", "edges": np.array(rows), "directed": True},
        "file": {"file": "office.csv", "directed": True},
    }[kind]
    topology = parse(value, tmp_path)
    assert (topology.directed, heard(topology, 4)) == (True, ONE_WAY)
    again = parse(topology.form, tmp_path)
    assert (again.edges, again.directed, again.content) == (topology.edges, True, topology.content)


def test_the_same_edges_both_ways_are_another_topology(tmp_path):
    one, both = (parse({"name": "x", "edges": [[0, 1]], "directed": d}, tmp_path) for d in (True, False))
    assert (heard(one, 2), heard(both, 2)) == ({(0, 1)}, {(0, 1), (1, 0)})
    assert one.content != both.content
    assert both.content == parse({"name": "x", "edges": [[1, 0]]}, tmp_path).content


@pytest.mark.parametrize(("form", "degree"), [
    ({"networkx": "gnp_random_graph", "p": 0.1, "directed": True}, None),
    ({"networkx": "random_k_out_graph", "k": 3, "alpha": 1.0}, 3),
    ({"networkx": "scale_free_graph"}, None),
])  # fmt: skip
def test_generators_that_make_directed_graphs(form, degree, tmp_path):
    topology = parse(form, tmp_path)
    topology.check(40)
    links = heard(topology, 40)
    assert any((v, u) not in links for u, v in links)
    assert all(u != v for u, v in links)
    if degree:
        assert np.bincount([u for u, _ in links], minlength=40).max() <= degree
    assert heard(topology, 40, 1) != links


def test_networkx_generator(tmp_path):
    topology = parse({"networkx": "watts_strogatz_graph", "k": 4, "p": 0.5}, tmp_path)
    assert str(topology) == "watts_strogatz_graph(k=4,p=0.5)"
    topology.check(10)
    one, two = links_of(topology, 20, 2), links_of(topology, 20, 2)
    assert (one.senders == two.senders).all()
    assert not nx.utils.graphs_equal(graph_of(one, 0, 20), graph_of(one, 1, 20))
    denser = parse({"networkx": "watts_strogatz_graph", "k": 4, "p": 0.51}, tmp_path)
    others = topology.links(20, 4, 0, 2, True, True), denser.links(20, 1, 0, 2, True, True)
    for t in (0, 1):  # the graph of a trial is its seed's, and its topology's
        graphs = [graph_of(links, t, 20) for links in (one, *others)]
        assert not any(nx.utils.graphs_equal(a, b) for a, b in itertools.combinations(graphs, 2))


def edges(*pairs, **keys):
    return {"name": "x", "edges": list(pairs)} | keys


@pytest.mark.parametrize(("value", "said"), [
    ("rng", "topology"),
    (3, "a topology is"),
    ({"name": "ring", "edges": []}, "taken"),
    ({"edges": []}, "a topology is"),
    (edges([0, 1], directed="yes"), "true or false"),
    (edges([0, 1], edge=[]), "a topology is"),
    (edges([0, True]), "edges are pairs"),
    (edges([0]), "edges are pairs"),
    (edges([-1, 0]), "edge"),
    (edges([0.5, 1]), "edges are pairs"),
    (edges([0, 1, 0.5]), r"edge \[0, 1, 0.5\] has three numbers: links have no weights"),
    (nx.Graph([(0, 1, {"weight": 0.5})]), "the graph's edges have numbers, weight = 0.5: links have no weights"),
    (nx.Graph([(0, 1, {"distance": np.float32(2)})]), r"distance = 2\.0"),
    (nx.MultiGraph([(0, 1), (1, 0)]), r"parallel edges.* networkx.Graph\("),
    (nx.MultiDiGraph([(0, 1)] * 2), r"parallel edges.* networkx.DiGraph\("),
    (nx.DiGraph([(0, 0)]), r"edge \(0, 0\) joins a robot to itself"),
    ({"networkx": "read_gpickle"}, "no graph generator"),
    ({"networkx": "watts_strogatz_graph", "k": 40, "p": 0.1}, "fails"),
    ({"networkx": "ladder_graph"}, "20 robots instead of 10"),
    # too large to be made
    ({"networkx": "hypercube_graph", "n": 100}, r"robots for n = \d+ already: give an n for 10 robots"),
    ({"networkx": "grid_2d_graph", "m": 10_000, "n": 10_000}, "robots for n = .* already"),
    ({"networkx": "dorogovtsev_goltsev_mendes_graph"}, "robots for n = .* already"),
])  # fmt: skip
def test_wrong_topologies_are_refused(value, said, tmp_path):
    with pytest.raises(ValueError, match=said):
        parse(value, tmp_path).check(10)


def test_other_numbers_on_edges_and_multigraphs_are_read(tmp_path):
    graph = nx.Graph([(0, 1, {"label": "x", "near": True, "weight": 1.0}), (1, 2)])
    for one in (graph, nx.MultiGraph([(0, 1), (1, 2)])):
        assert parse(one, tmp_path).edges == ((0, 1), (1, 2))
    assert parse(nx.MultiDiGraph([(0, 1), (1, 0)]), tmp_path).edges == ((0, 1), (1, 0))
    graph[1][2]["weight"] = 0.5
    with pytest.raises(sc.InputError, match=r"world.topology\[1\]"):
        study_of(topology=["ring", graph])


def test_a_topology_is_a_file_of_its_name(tmp_path):
    plain = ("full", "line", "moving", "ring", "scale-free")
    assert wiring.PLUGINS.shipped == tuple(sorted([*plain, "grid", "random-geometric", "small-world", "torus"]))
    for name in plain:
        topology = parse({"name": name}, tmp_path)
        assert topology == parse(name, tmp_path) == networks.Topology(name)
        assert (topology.form, topology.content, topology.edition) == (name, [name, None, None], "")
        assert topology.moves == (name == networks.MOVING)
        with pytest.raises(ValueError, match=f"topology {name} has no key columns: it has none"):
            parse({"name": name, "columns": 3}, tmp_path)


def test_a_file_next_to_the_study_comes_before_other_packages(tmp_path, monkeypatch):
    monkeypatch.setattr(plugins, "entry_points", lambda **_: pytest.fail("other packages were looked through"))
    wiring.PLUGINS.__dict__.pop("outside", None)
    (tmp_path / "torus").write_text("i,j\n0,1\n")
    assert parse("torus", tmp_path).edges == ((0, 1),)
    known = {"links.csv": FileEdges([(0, 2)], False)}
    assert networks.parse_topology("links.csv", None, known).edges == ((0, 2),)
    assert parse({"name": "torus", "edges": [[0, 3]]}, tmp_path).edges == ((0, 3),)


# ---- small worlds, grids, tori, random geometric graphs
@pytest.mark.parametrize(("robots", "rows", "columns"), [(30, 5, 6), (12, 3, 4), (9, 3, 3), (100, 10, 10), (18, 3, 6)])
@pytest.mark.parametrize("name", ["grid", "torus"])
def test_grids_and_tori_are_as_square_as_they_can_be(name, robots, rows, columns, tmp_path):
    right = nx.grid_2d_graph(rows, columns, periodic=name == "torus")
    for value in (name, {"name": name, "columns": columns}):
        topology = parse(value, tmp_path)
        topology.check(robots)
        assert nx.is_isomorphic(graph_of(links_of(topology, robots), 0, robots), right)


def test_named_columns_make_a_longer_grid(tmp_path):
    topology = parse({"name": "grid", "columns": 11}, tmp_path)
    topology.check(22)
    assert str(topology) == "grid(columns=11)"
    assert nx.is_isomorphic(graph_of(links_of(topology, 22), 0, 22), nx.grid_2d_graph(2, 11))


@pytest.mark.parametrize(("value", "robots", "said"), [
    ("grid", 22, "as 24 robots do: 2 x 11 is too long, unless columns are named"),
    ("grid", 7, "as 8 robots do: 1 x 7 is too long"),
    ("torus", 3, "as 9 robots do"),
    ({"name": "torus", "columns": 5}, 12, "columns = 5 makes no 3 or more whole rows"),
    ({"name": "torus", "columns": 5}, 10, "columns = 5 makes no 3 or more whole rows"),
    ({"name": "random-geometric", "radius": 0.01}, 50, "none of 100 graphs .* a larger radius is right"),
])  # fmt: skip
def test_networks_that_do_not_fit_are_refused(value, robots, said, tmp_path):
    with pytest.raises(sc.InputError, match=f"topology .* of {robots} robots.*{said}"):
        parse(value, tmp_path).check(robots)


@pytest.mark.parametrize("robots", [1, 2, 5, 6, 60])
@pytest.mark.parametrize(("neighbours", "rewired"), [(4, 0.0), (4, 0.1), (2, 1.0), (6, 1.0)])
def test_small_world_has_the_links_of_a_ring_lattice(robots, neighbours, rewired, tmp_path):
    topology = parse({"name": "small-world", "neighbours": neighbours, "rewired": rewired}, tmp_path)
    graph = graph_of(links_of(topology, robots, 2), 1, robots)
    lattice = nx.watts_strogatz_graph(robots, min(neighbours, robots - 1), 0) if robots > 2 else nx.path_graph(robots)
    if robots <= neighbours + 1:
        lattice = nx.complete_graph(robots)
    assert graph.size() == lattice.size()
    moved = len({*map(frozenset, graph.edges)} - {*map(frozenset, lattice.edges)})
    if robots == 60:  # a rewired link seldom lands on the lattice again; five standard errors
        chance = rewired * (1 - neighbours / 59)
        assert abs(moved - chance * graph.size()) <= 5 * (chance * (1 - chance) * graph.size()) ** 0.5 + 4
        assert nx.utils.graphs_equal(graph, lattice) == (rewired == 0)


@pytest.mark.parametrize("robots", [1, 2, 3, 20, 300])
def test_random_geometric_graphs_are_connected(robots, tmp_path):
    topology = parse("random-geometric", tmp_path)
    topology.check(robots)
    links = links_of(topology, robots, 20)
    graphs = [graph_of(links, trial, robots) for trial in range(20)]
    assert all(map(nx.is_connected, graphs))
    assert len({tuple(sorted(dict(graph.degree).items())) for graph in graphs}) == 20 or robots < 20


def test_random_geometric_robots_hear_all_within_the_radius():
    chance = Chance(np.array([1, 2], np.uint64), 5)
    for robots, radius in ((1, 0.3), (40, 0.3), (40, 1.4), (300, 0.15)):
        places = chance.uniform(2 * robots).reshape(-1, 2)
        apart = np.hypot(*(places[:, np.newaxis] - places).transpose(2, 0, 1))
        near = {(i, j) for i, j in np.argwhere(apart <= radius).tolist() if i < j}
        assert {*map(tuple, random_geometric.edges(robots, chance, radius=radius).tolist())} == near


# ---- labels
SMALL_WORLD = {"networkx": "watts_strogatz_graph", "k": 4, "p": 0.1}


@pytest.mark.parametrize("value", [SMALL_WORLD, {"name": "torus"}, {"name": "x", "edges": [[0, 1]]}, {"file": "e.csv"}])
def test_a_label_names_a_topology_and_changes_no_number(value, tmp_path):
    (tmp_path / "e.csv").write_text("i,j\n0,1\n")
    plain, labelled = parse(value, tmp_path), parse({**value, "label": "small world"}, tmp_path)
    assert (plain, plain.content) == (labelled, labelled.content)
    assert (str(labelled), labelled.name) == ("small world", str(plain))
    assert str(parse(labelled.form, tmp_path)) == "small world"


@pytest.mark.parametrize(("topologies", "said"), [
    ([{**SMALL_WORLD, "label": "a"}, {"name": "ring", "label": "a"}], '"a": two topologies have this label'),
    (["ring", {"name": "line", "label": "ring"}], '"ring": this label is the name of another topology or floor'),
    (["ring", {"name": "ring", "label": "a"}], "world.topology have one name: ring, ring"),
    ({"name": "ring", "label": ""}, "label should be a text, and not empty"),
    ({"name": "moving", "label": "walkers"}, 'always called "moving"'),
    ({"name": "ring", "label": "a\nb"}, "no control characters"),
])  # fmt: skip
def test_wrong_labels_are_refused(topologies, said):
    with pytest.raises(sc.InputError, match=said):
        study_of(robots=12, topology=topologies)


def test_a_label_is_the_name_in_results_and_figures(here, accepted):
    keys = {"robots": 8, "rounds": 5, "seed": 3}
    runs = [sc.run(study_of(topology={"name": name, "label": "a net"}, **keys), jobs=1) for name in ("ring", "line")]
    plain = sc.run(study_of(topology="ring", **keys), jobs=1)
    assert runs[0]["topology"].values.tolist() == ["a net"]
    assert runs[0]["final_estimate"].equals(plain["final_estimate"].assign_coords(topology=runs[0]["topology"]))
    assert sc.verify(runs[0], 1).differences == sc.verify(runs[0], 1).labels == []
    with pytest.raises(sc.InputError, match="topology 'a net': the label of two topologies, ring and line"):
        sc.merge(runs)
    sc.save(sc.merge([runs[0], sc.run(study_of(topology="full", **keys), jobs=1)]), "x.nc")
    printed = accepted("show", "x.nc", "--where", 'topology == "a net"').out
    assert "a net" in printed
    assert "full" not in printed
    texts = sc.plot.scatter(sc.load("x.nc"), color="topology").findobj(matplotlib.text.Text)
    assert any("a net" in text.get_text() for text in texts)


# ---- graphs of other programs
PATH, BACK = nx.path_graph(4), nx.DiGraph([(3, 0), (0, 1)])
BACK.add_node(2)


def test_graphs_with_a_byte_order_mark_and_without_names(tmp_path):
    text = "graph [ node [ id 0 ] node [ id 1 ] node [ id 2 ] edge [ source 0 target 1 ] edge [ source 1 target 2 ] ]"
    (tmp_path / "a.gml").write_text(text, encoding="utf-8-sig")
    assert read_graph(tmp_path / "a.gml", False).pairs == [(0, 1), (1, 2)]


WRITE = {"graphml": nx.write_graphml, "gml": nx.write_gml, "gexf": nx.write_gexf}


@pytest.mark.parametrize("ending", WRITE)
@pytest.mark.parametrize("graph", [PATH, BACK], ids=["undirected", "directed"])
def test_graph_files_are_read(ending, graph, tmp_path):
    WRITE[ending](graph, tmp_path / f"office.{ending}")
    topology = parse(f"office.{ending}", tmp_path)
    assert (topology.name, topology.directed, topology.nodes) == ("office", graph.is_directed(), 4)
    assert topology.edges == tuple(sorted(graph.edges))
    with pytest.raises(ValueError, match=rf"office.{ending} has 4 nodes: should be as many as robots, 6"):
        topology.check(6)
    assert not parse({"file": f"office.{ending}", "directed": False}, tmp_path).directed


@pytest.mark.parametrize("ending", WRITE)
def test_nodes_with_names_are_numbered_in_the_order_of_the_file(ending, tmp_path):
    WRITE[ending](nx.Graph([("hall", "attic"), ("attic", "7")]), tmp_path / f"x.{ending}")
    assert parse(f"x.{ending}", tmp_path).edges == ((0, 1), (1, 2))


@pytest.mark.parametrize("ending", WRITE)
def test_weights_of_graph_files_are_refused_or_left_out(ending, tmp_path):
    WRITE[ending](nx.Graph([(0, 1, {"weight": 0.5}), (1, 2, {"weight": 2.0})]), tmp_path / f"x.{ending}")
    with pytest.raises(sc.InputError, match=rf'x.{ending}: .*weight = 0.5: links have no weights.*weights = "ignore"'):
        parse(f"x.{ending}", tmp_path)
    assert parse({"file": f"x.{ending}", "weights": "ignore"}, tmp_path).edges == ((0, 1), (1, 2))


XML = "<graphml xmlns='http://graphml.graphdrawing.org/xmlns'>{}</graphml>".format
NODES = '<node id="a"/><node id="b"/><node id="c"/>'
EDGE = '<edge source="a" target="b" {}/>'


def graphml(edge="", default="", way="undirected"):
    """GraphML of three nodes and an edge."""
    key = f'<key id="d" for="edge" attr.name="w" attr.type="double"><default>{default or 1}</default></key>'
    return XML(f'{key}<graph edgedefault="{way}">{NODES}{EDGE.format(edge)}</graph>')


def gexf(nodes=NODES, way="directed", edges=""):
    graph = f'<graph defaultedgetype="{way}"><nodes>{nodes}</nodes><edges>{edges}</edges></graph>'
    return f'<gexf xmlns="http://www.gexf.net/1.2draft">{graph}</gexf>'


def gml(more):
    return f"graph [ node [ id 0 ] node [ id 1 ] edge [ source 0 target 1 {more} ] ]"


@pytest.mark.parametrize(("name", "text", "keys", "said"), [
    ("x.gml", "graph [\n node ]", {}, "x.gml: cannot be read as GML: .* found '\\]' at \\(2, 7\\)"),
    ("x.gml", "graph [ ] graph [ ]", {}, "more than one graph"),
    ("x.gml", "graph [ node [ id 0 ] edge [ source 0 target 1 ] ]", {}, "undefined target 1"),
    ("x.graphml", "0,1\n", {}, "x.graphml: cannot be read as GraphML: syntax error: line 1"),
    ("x.graphml", "<gexf><graph/></gexf>", {}, "not successfully read as graphml"),
    ("x.graphml", XML("<graph><hyperedge/></graph>"), {}, "hyperedges"),
    ("x.graphml", XML(f"<graph><node id='g'><graph>{NODES}</graph></node></graph>"), {}, "nodes within nodes.*table"),
    ("x.graphml", XML(f"<graph>{NODES}</graph><graph>{NODES}</graph>"), {}, "nodes within nodes, .*missing"),
    ("x.graphml", XML("<graph><edge source='a' target='b'/></graph>"), {}, "nodes within nodes, .*missing"),
    ("x.gexf", gexf('<node id="a"/><node id="b" pid="a"/>'), {}, "nodes within nodes"),
    ("x.gml", "graph [ node [ id 0 isGroup 1 ] node [ id 1 gid 0 ] ]", {}, "node 0 is a group of nodes"),
    ("x.gexf", gexf('<node id="a" start="1"/>'), {}, "links have times, .* a table source"),
    ("x.graphml", graphml(default=0.5), {}, 'w = 0.5: links have no weights.*weights = "ignore"'),
    ("x.graphml", graphml('directed="maybe"'), {}, "directed should be true or false"),
    ("x.graphml", graphml('directed="true"'), {}, "directed=true edge found in undirected graph"),
    ("x.gml", gml("weight 3"), {}, r"weight = 3: links have no weights"),
    ("x.gml", b"graph [\n\xe4 ]\n", {}, "x.gml: cannot be read as text: line 2 is not UTF-8"),
    ("x.gml", gml(""), {}, "x.gml has 2 nodes: should be as many as robots, 10"),
    ("x.gml", gml(""), {"directed": True}, "undirected graph: leave out directed"),
    ("x.gml", gml(""), {"renumber": True}, "renumber is for tables"),
    ("x.csv", "i,j\n0,1\n", {"weights": "use"}, 'weights should be "ignore"'),
    ("x.csv", "0,1\n1\n", {}, "line 2: 1 value .* where there should be 2"),
    ("x.csv", "i,j\na,b\nb,1\n", {}, "line 2: column 'i': 'a': should be a whole number from 0"),
    ("x.csv", "i,j\n1,2\n2,10\n", {}, "seem to start at 1; renumber = true numbers them from 0"),
    ("x.csv", "0 1 5\n", {}, 'third column: links have no weights.*weights = "ignore"'),
])  # fmt: skip
def test_what_may_be_misread_in_files_is_refused(name, text, keys, said, tmp_path):
    (tmp_path / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(ValueError, match=said):
        parse({"file": name, **keys}, tmp_path).check(10)


@pytest.mark.parametrize(("name", "text", "edges"), [
    ("x.gml", "graph [ node [ id 4 ] node [ id 7 ] edge [ source 4 target 7 id 3 ] edge [ source 7 target 4 ] ]",
     ((0, 1),)),
    ("x.gml", gml("graphics [ width 3 ] id 3"), ((0, 1),)),
    ("x.graphml", graphml('directed="true"', way="directed"), ((0, 1),)),
    ("x.gexf", gexf(edges=EDGE.format('id="9" type="mutual"')), ((0, 1), (1, 0))),
])  # fmt: skip
def test_links_go_the_ways_that_files_say(name, text, edges, tmp_path):
    (tmp_path / name).write_text(text)
    assert parse(name, tmp_path).edges == edges


@pytest.mark.parametrize(("name", "text"), [
    ("x.graphml", "<!--yFiles-->" + graphml(way="directed")),
    ("x.gml", 'Creator "yFiles"\n' + gml("").replace("[", "[ directed 1", 1)),
])  # fmt: skip
def test_of_files_of_yed_the_study_says_whether_links_are_directed(name, text, tmp_path):
    (tmp_path / name).write_text(text)
    with pytest.raises(sc.InputError, match=rf"{name}: .*yEd .*: say directed = true or false"):
        parse(name, tmp_path)
    assert parse({"file": name, "directed": False}, tmp_path).edges == ((0, 1),)
    assert parse({"file": name, "directed": True}, tmp_path).directed


@pytest.mark.parametrize(("text", "keys"), [
    ("source,target\nhall,attic\nattic,shed\n", {}),
    ("source\ttarget\tweight\n0\t1\t.5\n1\t2\t3\n", {"weights": "ignore"}),
    ("# a comment\n0 1 5\n1 2 7\n", {"weights": "ignore"}),
    ("0 1 {'weight': 0.5}\n1 2 {'weight': 3}\n", {"weights": "ignore"}),
    ("% KONECT\n1 2\n2 3\n", {"renumber": True}),
    ("i,j\n10,30\n30,200\n", {"renumber": True}),
    ("i,j\na,7\n7,b\n", {"renumber": True}),
])  # fmt: skip
def test_tables_with_weights_and_names_of_nodes(text, keys, tmp_path):
    (tmp_path / "x.csv").write_text(text)
    assert parse({"file": "x.csv", **keys}, tmp_path).edges == ((0, 1), (1, 2))


@pytest.mark.parametrize(("pairs", "links"), [
    ([], []),
    (iter([(1, 0), (0, 1), (2, 1)]), [(0, 1), (1, 0), (1, 2), (2, 1)]),
    ({(0, 2)}, [(0, 2), (2, 0)]),
    (np.array([[2, 1]], np.uint8), [(1, 2), (2, 1)]),
    (zip(range(2), range(1, 3), strict=True), [(0, 1), (1, 0), (1, 2), (2, 1)]),
])  # fmt: skip
def test_pairs_may_be_given_in_many_ways(pairs, links):
    receivers, senders = wiring.heard(wiring.pairs_of(pairs, 3), False)
    assert list(zip(receivers.tolist(), senders.tolist(), strict=True)) == links


@pytest.mark.parametrize("pairs", [
    [(0, 1), (1, 2, 0)], [0, 1], [(0.0, 1.0)], [("0", "1")], [(True, False)], [(0, 2**70)], np.zeros((1, 3), int),
])  # fmt: skip
def test_what_are_no_pairs(pairs):
    with pytest.raises(ValueError, match="its edges should be pairs of robot numbers, from 0"):
        wiring.pairs_of(pairs, 3)


def test_deterministic_generator_makes_one_graph(tmp_path):
    """As its edges do, given in full: robots that lose no message live the same lives."""
    star = {"networkx": "star_graph", "n": 4}
    topology = parse(star, tmp_path)
    assert not topology.varies
    assert parse({"networkx": "gnp_random_graph", "p": 0.5}, tmp_path).varies
    assert links_of(topology, 5, trials=7).starts.tolist() == [0, 8]
    assert nx.utils.graphs_equal(graph_of(links_of(topology, 5), 0, 5), nx.star_graph(4))
    one, other = (
        sc.run(study_of(rounds=20, trials=6, topology=form))["final_estimate"].values
        for form in (star, {"name": "star", "edges": [[0, k] for k in range(1, 5)]})
    )  # fmt: skip
    assert np.array_equal(one, other)
    assert len({trial.tobytes() for trial in one[0]}) == 6


def test_degrees_of_scale_free_networks(tmp_path):
    """P(k) = 4 / (k (k + 1) (k + 2)) for m = 1 (Bollobas et al. 2001): chi-square, 0.1 % level, fixed seed."""
    degrees = np.bincount(links_of(parse("scale-free", tmp_path), 20_000).receivers, minlength=20_000)
    k = np.arange(1, 9)
    law = 4 / (k * (k + 1) * (k + 2))
    found = np.append([(degrees == j).sum() for j in k], (degrees > 8).sum())
    assert stats.chisquare(found, np.append(law, 1 - law.sum()) * 20_000).pvalue > 1e-3


# ---- r-robustness and (r, s)-robustness against known graphs and against their definitions, told by sets of Python
def pairs_of_sets(graph):
    """Every two disjoint sets of nodes, neither empty."""
    for sides in itertools.product((0, 1, 2), repeat=len(graph)):
        found = [{node for node, side in zip(graph, sides, strict=True) if side == k} for k in (1, 2)]
        if all(found):
            yield found


def hears(graph, node):
    return set(graph.predecessors(node) if graph.is_directed() else graph[node]) - {node}


def reaching(graph, some, r):
    """How many of a set hear r nodes or more outside it."""
    return sum(len(hears(graph, node) - some) >= r for node in some)


def robust(graph, r, s):
    found = ([(len(side), reaching(graph, side, r)) for side in sides] for sides in pairs_of_sets(graph))
    return all(any(size == far for size, far in both) or sum(far for _, far in both) >= s for both in found)


def largest_r(graph):
    """By the definition of r-robust itself, which does not speak of s."""
    r = 0
    while all(reaching(graph, one, r + 1) or reaching(graph, other, r + 1) for one, other in pairs_of_sets(graph)):
        r += 1
    return r


def some_graphs():
    random = np.random.default_rng(3)
    for n in (2, 3, 4, 5, 6):
        for directed in (False, True):
            for _ in range(4):
                seed, p = int(random.integers(1000)), float(random.uniform(0.3, 0.95))
                yield nx.gnp_random_graph(n, p, seed=seed, directed=directed)


@pytest.mark.parametrize("graph", some_graphs(), ids=str)
def test_both_are_what_their_definitions_say(graph):
    assert r_robustness(graph) == largest_r(graph)
    for r, s in itertools.product(range(len(graph)), range(1, len(graph) + 1)):
        assert is_rs_robust(graph, r, s) == robust(graph, r, s), (r, s)


@pytest.mark.parametrize("n", range(1, 13))
def test_complete_graphs(n):
    most = (n + 1) // 2
    assert r_robustness(nx.complete_graph(n)) == r_robustness("full", n) == most
    assert is_rs_robust("full", most, n, n)
    assert n == 1 or not is_rs_robust("full", most + 1, 1, n)


def test_hearers_of_a_directed_edge():
    """All hear robot 0, and it hears nobody: a set with it and one without, of which one hears."""
    out, back = [(0, k) for k in range(1, 5)], [(k, 0) for k in range(1, 5)]
    assert r_robustness(out, directed=True) == r_robustness(nx.DiGraph(out)) == 1
    assert r_robustness(back, directed=True) == 0  # robots 1 and 2 hear nobody
    assert r_robustness(out) == r_robustness(back) == 1


def test_every_form_of_a_graph():
    edges = [(0, 1), (1, 2), (2, 0), (2, 3), (3, 0)]
    forms = [
        edges, np.array(edges), nx.Graph(edges), nx.relabel_nodes(nx.Graph(edges), dict(enumerate("abcd"))),
        nx.relabel_nodes(nx.Graph(edges), {0: 7, 1: 3, 2: 20, 3: 5}), {"name": "square", "edges": edges},
        networks.parse_topology({"name": "square", "edges": edges}, None, {}), nx.Graph([*edges, (1, 1)]),
    ]  # fmt: skip
    assert [r_robustness(form) for form in forms] == [2] * len(forms)
    assert r_robustness(edges, 5) == 0  # and a robot that hears nobody


@pytest.mark.parametrize(("ask", "said"), [
    (lambda: r_robustness("ring", 13), "13 robots: should be 1 to 12"),
    (lambda: r_robustness(nx.Graph()), "0 robots: should be 1 to 12"),
    (lambda: r_robustness("ring"), "say how many robots"),
    (lambda: r_robustness("scale-free", 8), "'scale-free' differs from trial to trial"),
    (lambda: r_robustness([(0, 4)], 3), "leads to a robot that is not there"),
    (lambda: is_rs_robust("full", 2, 0, 5), "s from 1 to the number of robots, 5"),
    (lambda: is_rs_robust("full", -1, 1, 5), "r is from 0 on"),
    (lambda: r_robustness([(0, 1)], True), "robots = True: should be a whole number"),
    (lambda: is_rs_robust("full", True, 1, 4), "r = True: should be a whole number"),
    (lambda: is_rs_robust("full", 1, "1", 4), "s = '1': should be a whole number"),
    (lambda: r_robustness([(0, 1)], directed="yes"), "directed = 'yes': should be True or False"),
    (lambda: r_robustness(5), "graph = 5: should be a networkx graph"),
    (lambda: r_robustness([1, 2]), "edges are pairs of robot numbers"),
    (lambda: r_robustness(nx.path_graph(3), 7), "robots = 7: the graph has 3 nodes: should be 3, or left out"),
    (lambda: r_robustness({"networkx": "star_graph", "n": 4}, 4), "gives 5 robots instead of 4"),
    (lambda: r_robustness({"networkx": "gnp_random_graph", "p": 0.5}, 4), "differs from trial to trial"),
])  # fmt: skip
def test_errors_say_what_is_right(ask, said):
    with pytest.raises(ValueError, match=rf"^.*{re.escape(said)}.*\Z"):  # in one line
        ask()
