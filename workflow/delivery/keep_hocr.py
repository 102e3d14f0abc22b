"""A plugin of OCRmyPDF that keeps the hOCR file of its text layer; OCRmyPDF loads it by its path."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Any

from ocrmypdf import OcrEngine, hookimpl
from ocrmypdf.builtin_plugins.tesseract_ocr import TesseractOcrEngine

# The environment variable with the path for the file; a plugin has no other way to learn it.
WHERE = "ORIGAMI_HOCR"


class _Keeping(TesseractOcrEngine):  # type: ignore[misc]
    @staticmethod
    def generate_hocr(input_file: Path, output_hocr: Path, output_text: Path, options: Any) -> None:
        """As Tesseract does, with a copy of the hOCR file."""
        TesseractOcrEngine.generate_hocr(input_file, output_hocr, output_text, options)
        shutil.copyfile(output_hocr, os.environ[WHERE])


@hookimpl(tryfirst=True)
def get_ocr_engine(options: Any) -> OcrEngine:
    """The engine that OCRmyPDF is to use."""
    return _Keeping()
