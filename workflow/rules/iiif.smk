# The tiles of each page. The manifest of all pages is written at the end, with the summary, also if some documents have
# failed: `write_manifest` is for that.


def write_manifest():
    """Write the manifest and the info.json of all pages that are in tiles."""
    subprocess.run(
        [sys.executable, SCRIPTS / "iiif_manifest.py", f"{OUT}/iiif", f"--url={config['iiif_url']}"], check=False
    )


rule iiif:
    input:
        rules.page.output,
    output:
        f"{OUT}/iiif/{{document}}/tiles.json",
    params:
        document=f"{OUT}/{{document}}",
        iiif=f"{OUT}/iiif",
    resources:
        mem_mb=500,
    shell:
        "{sys.executable:q} {SCRIPTS:q}/iiif_tiles.py {params.document:q} {params.iiif:q}"
