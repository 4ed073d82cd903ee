"""A network that paints a face's texture as another expression would show it (expressions paper, section 3.3)."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
import torch

from caricli.methods.train.kernel_muon import normalised_kernels
from caricli.methods.train.network_training import NetworkTraining
from caricli.methods.train.processes import ALL, Share
from caricli.methods.train.texture.texture_losses import (
    TextureBatch,
    attention_loss,
    colour_loss,
    critic_loss,
    cycle_loss,
    fooling_loss,
)
from caricli.methods.train.texture.texture_pairs import TexturePairs
from caricli.models.texture.config import TextureConfig
from caricli.models.texture.networks import TextureCritic, TextureNetwork
from caricli.seeds import TrainingSeed

_MOMENTS = (0.5, 0.9)
"""Decay rates of the critic's Adam (Gulrajani et al. 2017)."""


class TextureTraining(NetworkTraining):
    """Training of a TextureNetwork, as every NetworkTraining.

    First with pairs, then without (section 4.1); a critic of its own learns beside it at one of ``judge_every`` steps.
    Errors are mean differences of textures from the true ones, shares of those of the texture kept as it is.
    """

    def __init__(
        self,
        pairs: TexturePairs,
        unseen: TexturePairs,
        config: TextureConfig,
        share: Share = ALL,
        drawings: TexturePairs | None = None,
    ) -> None:
        """pairs: to train with. unseen: to validate with. drawings: those that the unpaired part is trained with, or
        None for ``pairs`` without their being pairs.
        """
        self.pairs = pairs
        self.unseen = unseen
        self.drawings = pairs if drawings is None else drawings
        super().__init__(partial(TextureNetwork, config.network()), config, share)
        generator = torch.Generator().manual_seed(config.seed)
        self.critic = TextureCritic(config.critic_width, config.size, generator)
        self._number = 0
        self.judging = torch.optim.AdamW(
            self.critic.parameters(), lr=config.critic_rate, betas=_MOMENTS, weight_decay=config.weight_decay
        )

    def _kernels(self) -> Sequence[torch.Tensor]:
        return normalised_kernels(self.network) if self.config.kernel_rate else ()

    def _parts(self) -> dict[str, Any]:
        return super()._parts() | {"critic": self.critic, "judging": self.judging}

    @property
    def _paired(self) -> bool:
        return self.epoch < self.config.paired_epochs

    def _draw(self, step: int) -> TextureBatch:
        """This process's pairs of a step."""
        generator = np.random.default_rng([self.config.seed, TrainingSeed.STEP, self.epoch, step])
        people = self.pairs if self._paired else self.drawings
        rows = slice(self.share.process, None, self.share.count)
        return people.draw(self.config.batch, generator, paired=self._paired).rows(rows)

    def _step(self, step: int, drawn: TextureBatch) -> torch.Tensor:
        self._number = step
        return super()._step(step, drawn)

    def _loss(self, drawn: TextureBatch) -> tuple[torch.Tensor, torch.Tensor]:
        """The loss of pairs, and the difference from the true textures over that of those that are kept."""
        config = self.config
        with torch.autocast("cpu", torch.bfloat16, config.precision == "bfloat16"):
            change = drawn.change(self.network)
            fake = change.paint(drawn.source)
            colour = colour_loss(fake, drawn.target, drawn.weight)
            if drawn.paired:
                loss = config.colour_weight * colour
                if config.attention:
                    loss = loss + config.attention_weight * attention_loss(change, drawn)
            else:
                loss = config.cycle_weight * cycle_loss(self.network, fake, drawn)
        if self._number % config.judge_every == 0:
            self._teach_critic(drawn, fake)
            self.critic.requires_grad_(False)
            loss = loss + fooling_loss(self.critic, drawn, fake, config)
            self.critic.requires_grad_(True)
        kept = colour_loss(drawn.source, drawn.target, drawn.weight)
        return loss, (colour / kept).detach()

    def _teach_critic(self, drawn: TextureBatch, fake: torch.Tensor) -> None:
        """Let the critic go a step down. fake: (B, 3, S, S) what became of the sources."""
        place = (self.epoch, self._number, self.share.process)
        generator = np.random.default_rng([self.config.seed, TrainingSeed.EXTRA, *place])
        shares = torch.from_numpy(generator.random(len(fake), np.float32))
        self._descend(self.critic, critic_loss(self.critic, drawn, fake, shares, self.config), self.judging)

    def _set_rate(self, step: int) -> None:
        super()._set_rate(step)
        share = self.optimiser.param_groups[0]["lr"] / self.config.learning_rate
        for group in self.judging.param_groups:
            group["lr"] = share * self.config.critic_rate

    @torch.no_grad()
    def _validate(self) -> float:
        """The average's mean difference from unseen people's true textures, a share of that of those kept."""
        self.average.eval()
        generator = np.random.default_rng([self.config.seed, TrainingSeed.VALIDATION])
        sums = torch.zeros(2)
        for _ in range(-(-self.config.validation // self.config.batch)):
            batch = self.unseen.draw(self.config.batch, generator, paired=True)
            fake = batch.change(self.average).paint(batch.source)
            pictures = (fake, batch.source)
            sums += torch.stack([colour_loss(picture, batch.target, batch.weight) for picture in pictures])
        return float(sums[0] / sums[1])
