# The tiles of each page. The manifest of all of them is written at the end of the batch, whether all documents ended
# well or not: write_manifest is called where the summary is written.


def write_manifest():
    """Write the manifest, and the info.json of each page in tiles; its failure does not spoil the batch."""
    # Without an address, for a look on this computer.
    url = config["iiif_url"] or "http://localhost:8000/iiif"
    subprocess.run([sys.executable, SCRIPTS / "iiif_manifest.py", f"{OUT}/iiif", f"--url={url}"], check=False)


rule iiif:
    input:
        rules.page.output,
    output:
        f"{OUT}/{{document}}/batch/iiif.json",
    log:
        f"{OUT}/{{document}}/batch/iiif.log",
        f"{OUT}/{{document}}/batch/iiif.failed.json",
    params:
        document=f"{OUT}/{{document}}",
        command=lambda wildcards: [
            sys.executable,
            str(SCRIPTS / "iiif_tiles.py"),
            f"{OUT}/{wildcards.document}",
            f"{OUT}/iiif",
        ],
    resources:
        mem_mb=500,
    shell:
        RECORD + " {params.command:q}"
