"""What liars cost, by world and by kind: `python benchmarks/liars.py RESULTS.nc`, of studies/beyond/liars*.toml.

Medians of the final errors over honest robots and trials, then means over settings. inf: estimates are no numbers any
more, as those of commons where somebody shouts.
"""

import sys

import numpy as np

import swarmcensus as sc

if __name__ == "__main__":
    results = sc.load(sys.argv[1])
    error = abs(results["final_estimate"] - results["fill_ratio"]).median(["trial", "robot"])
    table = error.to_dataframe("error").fillna({"error": np.inf})
    table["kind"] = table["adversary"].str.split("/").str[-1]
    table["world"] = table["topology"].str.split("(").str[0] + " " + table["robots"].astype(str)
    table["share"] = (table["liars"] / table["robots"]).round(1)
    order = list(dict.fromkeys(table["brain"]))
    for rows in (["world", "share"], ["kind", "share"]):
        part = table if rows[0] == "world" else table[table["robots"] == 20]
        print(part.pivot_table("error", rows, "brain", "mean", sort=False)[order].round(4).to_string())
