# A text layer for each page. The output is the last file to be put in place: with it, the folder is complete. Snakemake
# deletes it before it makes it again, so nobody should edit it; text.py keeps the other files if somebody has.


rule text:
    input:
        rules.page.output,
    output:
        f"{OUT}/{{document}}/text/page.pdf",
    params:
        document=f"{OUT}/{{document}}",
        languages=lambda wildcards: DOCUMENTS[wildcards.document].languages or "eng",
    resources:
        mem_mb=1000,
    shell:
        "{sys.executable:q} {SCRIPTS:q}/text.py {params.document:q} --languages {params.languages:q}"
