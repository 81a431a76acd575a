"""Commands that cannot be: one sentence says why, and no file changes."""

import pytest

import swarmcensus as sc
from swarmcensus import brains
from swarmcensus.support.options import option, shell_options
from tests.support.contending import made_up

STUDY = """
trials = 3
swarm = {robots = 6, accuracy = [0.7, 0.9], brain = "minimalistic"}
world = {topology = "ring", fill_ratio = [0.55, 0.95]}
schedule = {rounds = 20}
"""
LAME = brains.load("minimalistic").source.replace("def fuse", "def fuze")
REFUSALS = r"""
brains --show a --check b | brains: --show does not go with --check
brains --show commons --json | --json does not go with an option that prints a program or a document
brains | brains: needs --check or --show; 'swarmcensus list brains' lists all
brains swift | brains: swift is an argument too many
compare x.nc --margin 1_0 | compare: --margin 1_0: should be a number, or NAME=number
deploy commons --robot -1 | deploy: --robot -1: should be a whole number from 0
deploy commons out --target argos --set robots=3 | --set goes with --study
deploy commons robot --accuracy nan --target udp | --accuracy nan:
deploy commons robot --target ros2 | --target ros2: should be one of argos, c
export . --out a.mcap | it holds no log
export a.nc --out foo | a.nc: there is no such file
export good.nc --setting 18 | one setting is --where 'setting == N'
export good.nc --out rows.csv --save rows.csv | cannot write rows.csv: it is an input
infer none.csv --accuracy 0.8 | none.csv: there is no such file
infer obs.csv | --accuracy or --study is missing
infer obs.csv --accuracy 0.8 --links bad.csv | names a robot that is not there
infer obs.csv --accuracy 0.8 --plot folder.png | cannot write folder.png: it is a folder
infer obs.csv --accuracy 0.8 --set robots=3 | --set goes with --study
infer obs.csv --accuracy x | --accuracy x: there is no such file, and a sensor
list foo | KIND foo: should be studies
merge good.nc folder.nc --out x.nc | results file folder.nc: it is a folder
new -- -x.toml | did you mean 'swarmcensus new study ./-x.toml'?
new brain there.toml/x.py | cannot write there.toml/x.py
new brain x.toml | x.toml: a brain is a .py file
new mine.py | did you mean 'swarmcensus new brain mine.py'?
new ring x.nc | x.nc: a study is a .toml file
new rng | rng: no such study comes with swarmcensus: did you mean 'ring'? should be study, brain, or a name of
new study there.toml | there.toml already exists: name another file
new study x.py | x.py: a study is a .toml file
plot good.nc --kind heatmap --brain-file mine.py | --kind heatmap has no key brain_file: it has
plot good.nc --kind heatmap --local | --kind heatmap has no key local
plot good.nc --kind heatmap --setting 0 | --kind heatmap has no key setting
plot good.nc --local | local
plot good.nc --out x.bmp | figures are written as
replay good.nc --setting 0 --trial 0 --out new.nc --recording obs.csv | obs.csv is a file, not a folder
replay x.nc | replay: --setting is missing: 'swarmcensus replay --help' shows what there is
reproduce --only | --only: a value is missing after it
reproduce --only fig2 rivals | did you mean 'swarmcensus reproduce rivals'?
reproduce --out hello.toml/x | cannot write
run broken.toml | broken.py, line 1: not Python
run folder.nc | study file folder.nc: cannot be read: Is a directory
run good.nc | good.nc holds results, not a study: see them with swarmcensus show good.nc
run hello.toml --jobs 0 | run: --jobs 0: should be a whole number from 1
run hello.toml --jobs 9999 | swarmcensus: --jobs 9999: should be 1 to
run hello.toml --out folder.nc | cannot write folder.nc: it is a folder
run hello.toml --out hello.toml/x.nc | cannot write hello.toml/x.nc
run hello.toml --out other.nc --save wrong.doc | what this writes ends in .json or
run lame.toml | lame.py: the function fuse is missing
run x.toml --share ١/٤ | should be such as 1/4
run x.toml --trials | run: --trials: a value is missing after it
run x.toml --trials 3 --trials 4 | run: --trials is given twice, and holds one value
run x.toml y.toml | run: y.toml is an argument too many: 'swarmcensus run --help' shows what there is
show /dev/null | results file /dev/null: it is no file
show cut.nc | results file cut.nc: not a readable netCDF-4 file
show good.nc --save good.nc | good.nc: what this writes ends in
show good.nc --save two.doc | what this writes ends in .json or
show good.nc --where setting==1==1 | a chain has a coordinate between
show hello.toml | hello.toml is a study, not results: first run it with swarmcensus run hello.toml
show x.nc --quiet=3 | show: --quiet takes no value, but has '3'
show x.nc --sort= | show: --sort '': should not be empty
status good.nc --save s.csv | this answer has no rows
studies | did you mean 'list studies'?
calibrate obs.csv ./obs.csv | obs.csv is given twice
deploy commons f --target kilobot --robots far.toml | far.toml: number = 0: should be from 1 to 65534
swarm steadfast --on far.toml --watch | far.toml: number = 2000: the live page has places up to 1,999
swarm --jit=2 | swarm: --jit is no option of this command: did you mean '--jitter'?
verify good.nc --all --seed 3 | --seed 3
watch --port 99999 | --port 99999: should be a port
"""  # a command, and what is said of it


@pytest.mark.parametrize("line", REFUSALS.strip().splitlines())
def test_of_commands(line, here, refused, small_file):
    whole = small_file.read_bytes()
    for name, data in (("good.nc", whole), ("cut.nc", whole[: len(whole) // 2])):
        (here / name).write_bytes(data)
    texts = {"obs.csv": "1,1\n0,1\n", "bad.csv": "0,2\n", "there.toml": "mine", "hello.toml": STUDY}
    for name, source in (("broken", "def observe(:\n"), ("lame", LAME)):
        texts |= {f"{name}.py": source, f"{name}.toml": STUDY.replace("minimalistic", f"{name}.py")}
    texts["far.toml"] = "robots = [{number = 0, b = 0.9, w = 0.8}, {number = 2000, b = 0.9, w = 0.8}]"
    for name, text in texts.items():
        (here / name).write_text(text)
    for name in ("folder.nc", "folder.png"):
        (here / name).mkdir()
    command, _, said = line.partition(" | ")
    assert said in refused(*command.split())


# ---- messages call options as whoever asks would write them: `--against swift` in a shell, `against='swift'` in Python
def test_an_option_is_written_as_it_would_be_given():
    told = [option("against", "swift"), option("out"), option("fresh", True)]
    assert told == ["against='swift'", "out=", "fresh=True"]
    with shell_options(["against", "error_limit", "out", "fresh"]):
        told = [option("against", "a b"), option("error_limit", 2), option("out"), option("fresh", True)]
    assert told == ["--against 'a b'", "--error-limit 2", "--out", "--fresh"]
    with shell_options(["metric", "option"]):
        told = [option("metric", "correct"), option("against", "swift")]
    assert told == ["--metric correct", "--option against=swift"]
    assert option("out") == "out="


@pytest.mark.parametrize(("ask", "said"), [
    (lambda data: sc.plot.compare(data, against="swit"), "against='swit': "),
    (lambda data: sc.compare(data, against="swit"), "against='swit': "),
    (lambda data: sc.compare(data, metric="rubbish"), "metric='rubbish': "),
    (lambda data: sc.compare(data, where="robots = 3"), "where='robots = 3': "),
    (lambda data: sc.plot.ranks(data, metric="final_error:up"), "metric='final_error:up': "),
    (lambda data: sc.plot.compare(data, rows="colour"), "rows='colour': "),
])  # fmt: skip
def test_python_reads_of_its_arguments(ask, said):
    with pytest.raises(sc.InputError) as caught:
        ask(made_up())
    assert str(caught.value).startswith(said)
    assert "--" not in str(caught.value)
