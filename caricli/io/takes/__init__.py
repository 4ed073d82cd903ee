"""What moves a face over time: takes of weights, mouth cues, timecodes."""
