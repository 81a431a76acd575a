"""Tables as pandas, R, Excel, Gephi, igraph, networkx, SNAP and ROS write them: read right, or refused with advice."""

import re

import networkx as nx
import numpy as np
import pandas as pd
import pytest

import swarmcensus as sc
from swarmcensus import worlds
from swarmcensus.cli.commands import main
from swarmcensus.simulation import rows_of
from swarmcensus.summaries import recordings
from swarmcensus.worlds.networks import parse_topology

NAN = np.nan
PATH = [[0, 1], [1, 2]]
SEEN = [[0, 1, 1], [1, 1, NAN], [1, 0, 0]]
FRAME = pd.DataFrame(SEEN)
NAMED = FRAME.rename(columns="robot {}".format)
PAIR = NAMED[["robot 0", "robot 1"]].astype(int)
LONG = FRAME.rename_axis("step").reset_index().melt("step", var_name="robot")
GEPHI = "Source,Target,Type,Id,Label,timeset,Weight\n0,1,{0},0,,,1.0\n1,2,{0},1,,,1.0\n"


def written(tmp_path, text):
    path = tmp_path / "table.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def read_links(path):
    return rows_of(worlds.read_links(path), recordings.NUMBERED)


def topology(path, **keys):
    return parse_topology({"file": path.name, **keys}, path.parent, {})


LINKS = {
    "any order": ("step,receiver,sender\n2,1,0\n", [[2, 0, 1]]),
    "any case": ("Step,Sender,Receiver\r\n2,0,1\r\n\r\n\r\n", [[2, 0, 1]]),
    "pandas": (pd.DataFrame(PATH, columns=["source", "target"]).to_csv(), PATH),
    "pandas with its own header": (pd.DataFrame(PATH).to_csv(index=False), [[0, 1], *PATH]),
    "R": ('"","from","to"\n"1",0,1\n"2",1,2\n', PATH),
    "R table": ('"V1" "V2"\n"1" 0 1\n"2" 1 2\n', PATH),
    "Excel": ("\ufeffSource;Target\r\n0;1\r\n1;2\r\n", PATH),
    "Excel with its separator": ("sep=;\r\nSource;Target\r\n0;1\r\n1;2\r\n", PATH),
    "Excel text": ("source\ttarget\r\n0\t1\r\n1\t2\r\n".encode("utf-16"), PATH),
    "Gephi": (GEPHI.format("Undirected"), PATH),
    "igraph": ("2 0\n0 1\n", [[2, 0], [0, 1]]),
    "networkx": ("\n".join(nx.generate_edgelist(nx.path_graph(3))), PATH),
    "SNAP": ("# Nodes: 3 Edges: 2\n# FromNodeId\tToNodeId\n0\t1\n1\t2\n", PATH),
    "KONECT": ("% sym unweighted\n1 2\n", [[1, 2]]),
    "a separator after names": ("i,j,\n0,1\n", [[0, 1]]),
    "messages of Gephi": ("Step,Sender,Receiver,Type\n2,0,1,Directed\n", [[2, 0, 1]]),
    "no messages": ("step,sender,receiver\n", []),
}


@pytest.mark.parametrize(("text", "links"), LINKS.values(), ids=LINKS)
def test_links_are_read_by_their_names(text, links, tmp_path):
    path = written(tmp_path, text)
    assert read_links(path).tolist() == links
    if links and len(links[0]) == 2:
        assert topology(path).edges == tuple(sorted({(min(pair), max(pair)) for pair in links}))


OBSERVATIONS = {
    "pandas": (NAMED.to_csv(), SEEN),
    "pandas with its own header": (FRAME.to_csv(), SEEN),
    "pandas without names": (FRAME.iloc[::-1].to_csv(index=False, header=False), SEEN[::-1]),
    "any order": (NAMED[["robot 2", "robot 0", "robot 1"]].to_csv(index=False), SEEN),
    "long": (LONG.to_csv(index=False), SEEN),
    "numbered steps": (NAMED.rename_axis("step").to_csv(), SEEN),
    "truth values": ("r1,r0\nTrue,False\nNA,NaN\n", [[0, 1], [NAN, NAN]]),
    "R": ('"","X0","X1"\n"1",0,1\n"2",NA,1\n', [[0, 1], [NAN, 1]]),
    "Excel": ("\ufeffRobot 0;Robot 1\r\n0,0;1,0\r\n;1\r\n", [[0, 1], [NAN, 1]]),
    "Excel text": ("Robot 0\tRobot 1\r\n\t\r\n0\t1\r\n".encode("utf-16"), [[NAN, NAN], [0, 1]]),
    "NumPy": ("1.000000000000000000e+00 0.000000000000000000e+00\nnan 1.0e+00\n", [[1, 0], [NAN, 1]]),
    "NumPy with names": ("# robot1 robot0\n0 1\n1 1\n", [[1, 0], [1, 1]]),
    "one robot": (NAMED[["robot 2"]].rename(columns={"robot 2": "0_"}).to_csv(index=False) + "\n\n", [[1], [NAN], [0]]),
    "a missing value of Excel": ("#N/A\n1\n#N/A\n0\n", [[NAN], [1], [NAN], [0]]),
    "a column of truth values": ("black\ntrue\nfalse\n", [[1], [0]]),
    "comments": ("# in the hall\nrobot 0,robot 1\n0,1\n# pause\n1,1\n", [[0, 1], [1, 1]]),
}


@pytest.mark.parametrize(("text", "seen"), OBSERVATIONS.values(), ids=OBSERVATIONS)
def test_observations_are_read_by_their_names(text, seen, tmp_path):
    assert np.array_equal(recordings.read_observations(written(tmp_path, text)).values, seen, equal_nan=True)


@pytest.mark.parametrize(("index", "said"), [
    ([2, 0, 1], "the first column or index is unnamed: drop it, or name it with .*Unnamed: 0"),
    ([0, 1, 5], "Its first row is Unnamed: 0 = 0"),
    (pd.date_range("2026-03-01", periods=3, freq="s"), "Unnamed: 0 = 2026-03-01"),
])  # fmt: skip
def test_an_index_that_does_not_count_rows_is_not_thrown_away(index, said, tmp_path):
    """In a data frame and in a Parquet file as in the CSV file of it."""
    frame = NAMED.set_axis(index)
    frame.to_parquet(tmp_path / "o.parquet")
    frame.to_csv(tmp_path / "o.csv")
    with pytest.raises(sc.InputError, match=f"observations: .*{said}"):
        inferred(frame, None)
    for name in ("o.parquet", "o.csv"):
        with pytest.raises(sc.InputError, match=said):
            recordings.read_observations(tmp_path / name)


def test_an_index_names_robots_of_a_matrix_and_times(tmp_path):
    names = ["zoe", "adam", "mia", "leo"]
    matrix = PATH_MATRIX.set_axis(names).set_axis(names, axis=1)
    matrix.to_parquet(tmp_path / "m.parquet")
    assert topology(tmp_path / "m.parquet").edges == ((0, 1), (1, 2), (2, 3))
    matrix.iloc[::-1].to_parquet(tmp_path / "m.parquet")
    with pytest.raises(sc.InputError, match="columns 'Unnamed: 0', 'zoe'"):
        topology(tmp_path / "m.parquet")
    NAMED.set_axis(pd.to_datetime([0, 1, 3], unit="s")).to_parquet(tmp_path / "o.parquet")
    found = recordings.read_observations(tmp_path / "o.parquet", time="Unnamed: 0", period=1)
    assert np.array_equal(found.values, [*SEEN[:2], [NAN] * 3, SEEN[2]], equal_nan=True)
    with pytest.raises(sc.InputError, match="two columns are named 'robot 0'"):
        inferred(NAMED.rename_axis("robot 0").iloc[::-1], None)


def test_accuracies_are_read_by_their_names(tmp_path):
    for text in (
        "white,black\n0.8,0.9\n", "\ufeffblack;white\r\n0,9;0,8\r\n", ",black,white\n0,0.9,0.8\n",
        "robot black white\n0 .9 .8\n",
    ):  # fmt: skip
        read = recordings.read_accuracy(str(written(tmp_path, text)))
        assert [read[name].tolist() for name in ("black", "white")] == [[0.9], [0.8]]


BOTH = "line 1: '{}' may be names of columns or .*if names, write .* instead; if .*, add a line"


@pytest.mark.parametrize(("read", "text", "said"), [
    (read_links, "source,target,weight\n0,1,2\n", "column 'weight': links have no weights"),
    (read_links, "0,1,2\n1,2,0\n", "3 columns without names: .*step,sender,receiver"),
    (read_links, pd.DataFrame([[2, 3]]).to_csv(index=False), BOTH.format("0,1")),
    (read_links, "sender,receiver\n0,1\n", "columns 'sender', 'receiver': .*step,sender,receiver"),
    (read_links, "time,sender,receiver\n0,1,2\n", "column 'time': times of messages .*period="),
    (read_links, "i,i\n0,1\n", "two columns are named 'i'"),
    (read_links, GEPHI.format("Directed"), "line 2: column 'Type': 'Directed': .*step,sender,receiver"),
    (read_links, 'source\ttarget\n0\t"1,000"\n1\t2\n', "line 2: column 'target': '1,000': .* mark of thousands"),
    (read_links, "source;target\n0;999\n1;1.000\n", "line 3: column 'target': '1.000': .* mark of thousands"),
    (read_links, "index,i,j\n5,0,1\n", "column 'index': .*Its first row is index = 5, i = 0, j = 1"),
    (topology, "%%MatrixMarket matrix coordinate real general\n3 3 1\n1 2 1\n", "is no table, .* with '%%Matrix"),
    (topology, nx.to_sparse6_bytes(nx.path_graph(3)), "is no table, .* with '>>sparse6"),
    (read_links, 'i,j\n0,"1\n2,3\n', "a cell in quotes goes on"),
    (topology, GEPHI.format("Directed"), "line 2: column 'Type': 'Directed': .*directed = true"),
    (topology, "0 1 0.5\n1 2 0.5\n", "line 1: .*links have no weights"),
    (topology, "\n".join(nx.generate_graphml(nx.path_graph(2))), "is no table, .* with '<graphml"),
    (topology, "\n".join(nx.generate_gml(nx.path_graph(2))), "is no table, .*save it as CSV"),
    (topology, b"0,1\xff", "line 1 is not UTF-8"),
    (topology, b"PK\x03\x04\x00", "it is no text"),
    (read_links, "a b\nb c\n", "'a b' may be names of columns or a link: .*add a line source,target"),
    (topology, "source,target,Source\n0,1,2\n", "columns 'source' and 'Source' have one name"),
    (topology, "# 0\n5 1\n# 1\n2 1\n", "line 1: '# 0' may be no comment: .*igraph's LGL as pairs"),
    (topology, "source,target\nr0,r1\n#1,r0\n", "line 3: '#1,r0' may be no comment: .*in quotes"),
    (recordings.read_observations, "step,robot,black\n0,a,1\n%b,a,1\n", "line 3: '%b,a,1' may be no comment"),
    (recordings.read_observations, "True\nFalse\nTrue\n", "'True' may be names of columns or readings"),
    (recordings.read_observations, "1,0\n1,1\n", BOTH.format("1,0") + " robot 1,robot 0"),
    (recordings.read_observations, PAIR.to_csv(index=False, header=["0", "1"]) , BOTH.format("0,1")),
    (recordings.read_observations, PAIR.to_csv(header=["0", "1"]), BOTH[7:].format("0,1")),
    (recordings.read_observations, "1,1\n0,2\n", "line 2: '2'"),
    (recordings.read_observations, PAIR.to_csv(sep=" ", header=["0", "1"]), "line 2: 3 values .* should be 2"),
    (recordings.read_observations, "step,robot,reading\n1,0,1\n", "steps are numbered from 0"),
    (recordings.read_observations, "step,robot,reading\n0,0,1\n0,0,1\n", "line 3: a second observation"),
    (recordings.read_observations, "step,robot,place\n0,0,1\n", "clear: .*reading='place'.*place = 1"),
    (recordings.read_observations, "robot 0,robot 1,battery\n0,1,1\n", "column 'battery': the others are numbered"),
    (recordings.read_observations, "robot 0\n0,1,0\n", "column 'robot 0': '0,1,0': should be 0"),
    (recordings.read_observations, "%time,field.data\n16048,1\n", "line 1: '%time,field.data' may be no comment"),
    (recordings.read_observations, "robot 0,robot 1\n0,1\n1,grey\n", "line 3: column 'robot 1': 'grey'"),
    (recordings.read_observations, "step\n0\n1\n", "no observations: .*step,robot,observation"),
    (recordings.read_observations, "robot 0\n1\n\n0\n", "line 3 is empty: write NA"),
    (recordings.read_accuracy, "robot,black\n3,0.9\n", "column 'robot'"),
    (recordings.read_accuracy, "black,white\n0.9,\n", "line 2: column 'white': '': should be a number"),
])  # fmt: skip
def test_what_may_be_misread_is_refused(read, text, said, tmp_path):
    path = written(tmp_path, text)
    with pytest.raises(sc.InputError, match=f"{re.escape(str(path))}.*{said}"):
        read(path if read is not recordings.read_accuracy else str(path))


def test_directed_edges_lead_from_source_to_target(tmp_path):
    assert topology(written(tmp_path, "target,source\n1,0\n"), directed=True).edges == ((0, 1),)
    assert topology(written(tmp_path, GEPHI.format("Directed")), directed=True).edges == ((0, 1), (1, 2))


def inferred(observations, links):
    return sc.infer(observations, links, 0.8, 1, compiled=False)


def test_data_frames_are_read_by_their_names():
    right = inferred(SEEN, PATH)
    for observations in (FRAME, NAMED[["robot 1", "robot 2", "robot 0"]].rename_axis("step"), LONG):
        assert right.equals(inferred(observations, nx.to_pandas_edgelist(nx.path_graph(3))))
    heard = pd.DataFrame({"receiver": [1, 2], "step": [0, 0], "sender": [0, 1]})
    assert inferred(SEEN, [[0, 0, 1], [0, 1, 2]]).equals(inferred(SEEN, heard))
    with pytest.raises(sc.InputError, match=r"links.*'distance'"):
        inferred(SEEN, pd.DataFrame({"source": [0], "target": [1], "distance": [2]}))


def test_arrays_are_not_guessed():
    assert inferred(SEEN, PATH).equals(inferred(np.ma.masked_array(np.nan_to_num(SEEN), np.isnan(SEEN)), PATH))
    for links, said in (
        (nx.to_numpy_array(nx.path_graph(4)), r"of shape \(4, 4\): should be \(edge, 2\)"),
        ([[0, 2**70]], "whole numbers"), ([[0, NAN]], "whole numbers"), (pd.DataFrame(), "columns i,j for edges"),
    ):  # fmt: skip
        with pytest.raises(sc.InputError, match=f"links.*{said}"):
            inferred(SEEN, links)


def test_an_accuracy_file_that_is_missing_is_named():
    with pytest.raises(sc.InputError, match=r"'nowhere\.csv': there is no such file"):
        recordings.read_accuracy("nowhere.csv")


def test_robots_without_links_are_named():
    for links, said in (([[1, 2]], "0 has no links; .*seem to start at 1"), ([[0, 0, 1]], "2 has no links$")):
        with pytest.warns(UserWarning, match=f"links: robot {said}"):
            inferred(SEEN, links)
    with pytest.raises(sc.InputError, match=r"numbered 0 to 2; .*seem to start at 1"):
        inferred(SEEN, [[1, 2], [2, 3]])
    study = {"trials": 1, "world": {"topology": {"name": "office", "edges": [[0, 3]]}, "fill_ratio": 0.5}}
    with pytest.warns(UserWarning, match="topology 'office' of 12 robots: robots 1, 2, 4, 5, 6, 7, 8, 9, ... have no"):
        sc.Study(swarm={"robots": 12, "accuracy": 0.8}, **study)


@pytest.mark.interpreted
def test_infer_writes_next_to_its_observations(here, monkeypatch, refused):
    monkeypatch.setattr("swarmcensus.figures.save", lambda *_: [])
    (here / "a").mkdir()
    (here / "a" / "o.csv").write_text("robot 0,robot 1\n1,0\n")
    (here / "o-trace.csv").write_text("another's")
    assert main(["infer", "a/o.csv", "--accuracy", "0.8"]) == 0
    (here / "l.csv").write_text("source,target,weight\n0,1,2\n")
    said = refused("infer", "a/o.csv", "--links", "l.csv", "--accuracy", "0.8", "--out", "x.nc")
    assert "l.csv: column 'weight'" in said
    assert {p.name for p in here.iterdir()} == {"a", "l.csv", "o-trace.csv"}
    assert {p.name for p in (here / "a").iterdir()} == {"o.csv", "o-trace.csv"}
    assert (here / "o-trace.csv").read_text() == "another's"


ROWS = [(100.0, "khepera_1", 1), (100.1, "khepera_10", 0), (100.52, "khepera_2", 1), (101.9, "khepera_1", 0)]
LABELS = ["khepera_1", "khepera_2", "khepera_10"]
ON_STEPS = [[1, NAN, 0], [NAN, 1, NAN], [NAN] * 3, [NAN] * 3, [0, NAN, NAN]]
STAMPS = [(f"2026-03-01T14:01:{second - 60:09.6f}", robot, black) for second, robot, black in ROWS]


@pytest.mark.parametrize(("rows", "names", "options"), [
    (ROWS, ["time", "robot", "black"], {}),
    (STAMPS, ["Timestamp", "Robot", "value"], {}),
    (ROWS, ["zeit", "wer", "boden"], {"time": "zeit", "robot": "wer", "reading": "boden"}),
])  # fmt: skip
@pytest.mark.parametrize("form", ["csv", "excel", "parquet"])
def test_times_become_steps_and_robots_keep_their_names(rows, names, options, form, tmp_path):
    frame, path = pd.DataFrame(rows, columns=names).assign(battery=3.7), tmp_path / f"o.{form}"
    if form == "parquet":
        frame.to_parquet(path)
    else:
        more = {"csv": {"sep": ";", "index": False}, "excel": {"sep": "\t", "encoding": "utf-16"}}[form]
        frame.to_csv(path, decimal=",", **more)
    found = recordings.read_observations(path, **options, period=0.5)
    assert found.labels == LABELS
    assert np.array_equal(found.values, ON_STEPS, equal_nan=True)
    assert found.notes == ["left out: column battery", "11 of 15 readings are missing: 2 of 5 steps have none"]
    with pytest.warns(UserWarning, match=r"left out|missing"):
        trace = sc.infer(frame, None, 0.8, 1, compiled=False, **options, period=0.5)
    assert trace["robot"].values.tolist() == LABELS


def test_wide_tables_have_any_names_and_the_last_reading_of_a_step_counts(tmp_path):
    found = recordings.read_observations(written(tmp_path, "t,bert,anna\n0,1,0\n0.9,0,\n1.1,1,1\n"), period=1)
    assert (found.labels, found.values.tolist()) == (["anna", "bert"], [[0, 1], [1, 1]])
    assert found.notes == ["1 reading left out: the last one of a robot in a step counts"]


def test_links_and_accuracies_name_robots_as_readings_do(tmp_path):
    path = written(tmp_path, pd.DataFrame(ROWS, columns=["t", "robot", "black"]).to_csv())
    seen = recordings.read_observations(path, period=0.5)
    matrix = pd.DataFrame([[0, 1, 0], [1, 0, 0], [0, 0, 0]], LABELS[::-1], LABELS[::-1])
    for text, links in (
        ("time,sender,receiver\n101.1,khepera_2,khepera_10\n", [[2, 1, 2]]),
        ("i,j\nkhepera_2,khepera_10\n", [[1, 2]]),
        (matrix.to_csv(), [[2, 1], [1, 2]]),
    ):
        assert rows_of(worlds.read_links(written(tmp_path, text)), seen).tolist() == links
    with pytest.raises(sc.InputError, match="line 2: column 'j': '9': should be one of the robots khepera_1"):
        rows_of(worlds.read_links(written(tmp_path, "i,j\nkhepera_2,9\n")), seen)
    for text in ("black\n.9\n.7\n.8\n", ",black\nkhepera_10,.9\nkhepera_1,.7\nkhepera_2,.8\n"):
        with pytest.raises(sc.InputError, match="and robot if robots have names"):
            recordings.read_accuracy(str(written(tmp_path, text)), seen)
    path = written(tmp_path, "robot,black\nkhepera_10,.9\nkhepera_1,.7\nkhepera_2,.8\n")
    assert recordings.read_accuracy(str(path), seen)["black"].tolist() == [0.7, 0.8, 0.9]


@pytest.mark.parametrize(("text", "options", "said"), [
    ("time,robot,black\n0.5,a,1\n", "", "column 'time': times need --period, .* time = 0.5, robot = a"),
    ("zeit,wer,b\n0,a,1\n", "--robot wer", "which column has the times is not clear: name it with --time"),
    ("time,wer,black\n0,a,1\n", "", "which column names the robots is not clear: name it with --robot"),
    ("time,robot,is_white\n0,a,1\n", "", "is not clear: name it with --reading is_white"),
    ("time,tick,robot,black\n0,0,a,1\n", "", "columns 'time' and 'tick' are there: .* --time time"),
    ("step,a,b\n0,1,1\n", "--time stepp", "--time stepp: o.csv has no such column: did you mean 'step'"),
    ("step,a\n1,1\n", "", "numbered from 0, and the first is 1 here: --period 1 counts them from it"),
    ("t;a\n1,000;1\n2,000;0\n", "--period 1", "'1,000': should be without a mark of thousands; --decimal ,"),
    ("time,robot,black\nyesterday,a,1\n", "--period 1", "line 2: column 'time': 'yesterday': should be seconds"),
    ("index,robot 0\n0,1\n", "--time index", "o.csv has no such column that does more than count the rows"),
    ("robot 0\n1\n", "--readings /{robot}", "--readings is for a bag"),
])  # fmt: skip
def test_what_a_table_lacks_is_named_with_its_option(text, options, said, here, refused):
    (here / "o.csv").write_text(text)
    assert re.search(said, refused("infer", "o.csv", "--accuracy", "0.8", *options.split()))


def test_decimal_commas_are_said(tmp_path):
    path = written(tmp_path, "t;a\n1,000;1\n2,000;0\n")
    assert np.array_equal(recordings.read_observations(path, ",", period=0.5).values, [[1], [NAN], [0]], equal_nan=True)


PATH_MATRIX = nx.to_pandas_adjacency(nx.path_graph(4), dtype=int)


@pytest.mark.parametrize("text", [
    PATH_MATRIX.to_csv(), PATH_MATRIX.to_csv(index=False), PATH_MATRIX.to_csv(index=False, header=False),
    PATH_MATRIX.set_axis(list("ABCD")).set_axis(list("ABCD"), axis=1).to_csv(sep=";"),
    PATH_MATRIX.astype(bool).to_csv(),
])  # fmt: skip
def test_adjacency_matrices_are_read(text, tmp_path):
    found = topology(written(tmp_path, text))
    assert (found.edges, found.nodes) == (((0, 1), (1, 2), (2, 3)), 4)
    one_way = PATH_MATRIX.where(np.triu(np.ones((4, 4))) > 0, 0)
    assert topology(written(tmp_path, one_way.to_csv()), directed=True).edges == found.edges


@pytest.mark.parametrize(("text", "keys", "said"), [
    (",A,B\nA,0,1\nB,0,0\n", {}, "not symmetric: robot 0 has a link to 1, and not back: see directed = true"),
    (",A,B\nA,0,1\nB,0,0\n", {"weights": "ignore"}, "not symmetric: robot 0 has a link to 1, and not back"),
    (",A,B\nA,0,0.5\nB,0.5,0\n", {}, "line 2: column 'B': links have no weights"),
])  # fmt: skip
def test_matrices_that_are_no_networks_are_refused(text, keys, said, tmp_path):
    with pytest.raises(sc.InputError, match=said):
        topology(written(tmp_path, text), **keys)
