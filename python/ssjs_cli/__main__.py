"""python -m ssjs_cli"""

from ssjs_cli.app import main

main()
