"""Studies: many runs of the estimator whose results are set side by side. A study is a folder that can be left and taken up again."""
