# Runs what the README shows, without Python on this machine:
#   docker build -t swarmcensus .
#   docker run --rm -v "$PWD:/work" swarmcensus swarmcensus reproduce
#   docker run --rm -w /swarmcensus swarmcensus pytest -n 2 -m "not long"
FROM python:3.12-slim
COPY . /swarmcensus
RUN pip install --no-cache-dir '/swarmcensus[test,watch]' -c /swarmcensus/constraints.txt
WORKDIR /work
CMD ["swarmcensus"]
